/// Rays.
#pragma once

#include "base/vec.h"

namespace bob {

struct Ray {
    Vec3 origin;
    Vec3 direction;  // finite, of any length but zero; t counts in its lengths
};

}  // namespace bob
