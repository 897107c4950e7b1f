#pragma once

#include "base/simd.h"
#include "base/vec.h"

namespace bob::BOB_ISA {
namespace {

/// One vector per lane.
struct Vector3 {
    F x, y, z;
};

inline F dot(const Vector3& a, const Vec3& b) { return a.x * constant(b.x) + a.y * constant(b.y) + a.z * constant(b.z); }
inline F dot(const Vector3& a, const Vector3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

}  // namespace
}  // namespace bob::BOB_ISA
