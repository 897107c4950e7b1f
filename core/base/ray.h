/// Rays.
#pragma once

#include "base/vec.h"

namespace bob {

struct Ray {
    Vec3 origin;
    Vec3 direction;  // finite, of any nonzero length; t is in its lengths
};

}  // namespace bob
