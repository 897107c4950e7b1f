/// Units of length.
#pragma once

#include <array>
#include <string_view>

namespace bob {

struct Unit {
    std::string_view name;
    double metres;
};

constexpr std::array<Unit, 12> units{{
    {"nm", 1e-9},
    {"um", 1e-6},
    {"mm", 1e-3},
    {"cm", 1e-2},
    {"dm", 1e-1},
    {"m", 1},
    {"km", 1e3},
    {"mil", 2.54e-5},
    {"in", 0.0254},
    {"ft", 0.3048},
    {"yd", 0.9144},
    {"mi", 1609.344},
}};

}  // namespace bob
