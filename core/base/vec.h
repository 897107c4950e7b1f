/// Three-component float vectors.
#pragma once

#include <cmath>

namespace bob {

struct Vec3 {
    float x = 0, y = 0, z = 0;

    constexpr float& operator[](int axis) { return this->*components[axis]; }
    constexpr float operator[](int axis) const { return this->*components[axis]; }

private:
    static constexpr float Vec3::*components[] = {&Vec3::x, &Vec3::y, &Vec3::z};
};

inline Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec3 operator-(Vec3 a) { return {-a.x, -a.y, -a.z}; }
inline Vec3 operator*(float s, Vec3 a) { return {s * a.x, s * a.y, s * a.z}; }
inline float dot(Vec3 a, Vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec3 cross(Vec3 a, Vec3 b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
inline float length(Vec3 a) { return std::sqrt(dot(a, a)); }
inline Vec3 min(Vec3 a, Vec3 b) { return {a.x < b.x ? a.x : b.x, a.y < b.y ? a.y : b.y, a.z < b.z ? a.z : b.z}; }
inline Vec3 max(Vec3 a, Vec3 b) { return {a.x > b.x ? a.x : b.x, a.y > b.y ? a.y : b.y, a.z > b.z ? a.z : b.z}; }

/// `a` scaled to length 1; zero if its length is zero, infinite or NaN.
inline Vec3 normalized(Vec3 a) {
    const float size = length(a);
    return size > 0 && std::isfinite(size) ? (1 / size) * a : Vec3{};
}

}  // namespace bob
