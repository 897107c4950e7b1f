/// The extreme points of a shape, found once for all its places.
#pragma once

#include "base/once.h"
#include "shapes/point_tree.h"

namespace bob {

using Outline = Once<PointTree>;

}  // namespace bob
