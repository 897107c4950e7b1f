#include "files/welding.h"

#include <bit>
#include <limits>
#include <new>

#include "base/interruption.h"
#include "files/binary.h"

namespace bob::files {

Welding::Welding(std::size_t corners) : slots_(std::bit_ceil(corners / 2 + 16), -1) { part_.triangles.reserve(corners); }

bool Welding::is_at(std::int32_t vertex, const double (&place)[3]) const {
    const double* const own = &part_.vertices[3 * static_cast<std::size_t>(vertex)];
    std::uint64_t difference = 0;  // NaN is NaN
    for (int k = 0; k < 3; ++k) difference |= std::bit_cast<std::uint64_t>(own[k]) ^ std::bit_cast<std::uint64_t>(place[k]);
    return difference == 0;
}

std::int32_t& Welding::find(const double (&place)[3]) {
    std::uint64_t hash = 0;
    for (const double x : place) hash = (std::rotl(hash, 5) ^ std::bit_cast<std::uint64_t>(x)) * 0x9e3779b97f4a7c15;
    const std::size_t mask = slots_.size() - 1;
    std::size_t at = static_cast<std::size_t>(hash >> 32) & mask;
    while (slots_[at] >= 0 && !is_at(slots_[at], place)) at = (at + 1) & mask;
    return slots_[at];
}

void Welding::grow() {
    Interruption::check();
    slots_.assign(2 * slots_.size(), -1);
    const double* own = part_.vertices.data();
    for (std::size_t vertex = 0; vertex < part_.vertices.size() / 3; ++vertex, own += 3) {
        find({own[0], own[1], own[2]}) = static_cast<std::int32_t>(vertex);
    }
}

void Welding::add(double x, double y, double z) {
    const double place[] = {x + 0, y + 0, z + 0};  // of -0 and 0, one
    const std::size_t count = part_.vertices.size() / 3;
    if (4 * (count + 1) > 3 * slots_.size()) grow();
    std::int32_t& slot = find(place);
    if (slot < 0) {
        if (count >= std::numeric_limits<std::int32_t>::max()) throw std::bad_alloc();
        slot = static_cast<std::int32_t>(count);
        for (const double own : place) part_.vertices.push_back(own);
    }
    part_.triangles.push_back(slot);
}

void Welding::add_facets(Bytes bytes, std::size_t count, bool has_attributes) {
    constexpr std::size_t normal = 12, size = 50;
    const std::uint8_t* at = bytes.data();
    for (std::size_t i = 0; i < count; ++i) {
        if (i % 65536 == 0) Interruption::check();
        const std::uint8_t* corner = at + normal;
        for (int k = 0; k < 3; ++k, corner += 12) {
            add(load<float>(corner, false), load<float>(corner + 4, false), load<float>(corner + 8, false));
        }
        at += size + (has_attributes ? load<std::uint16_t>(corner, false) : 0);
    }
}

}  // namespace bob::files
