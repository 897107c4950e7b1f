#include "files/draco/predictions.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <span>

#include "base/interruption.h"
#include "files/draco/corrections.h"
#include "files/draco/entropy.h"

namespace bob::files::draco {
namespace {

enum Prediction : std::int8_t { difference = 0, parallelogram = 1, parallelograms = 4, by_texture = 5, by_geometry = 6 };

/// An attribute's integers, each predicted from earlier ones.
class Predictor {
public:
    Predictor(Attribute& attribute, const Sequence& sequence, const Positions& positions)
        : attribute_(attribute), sequence_(sequence), positions_(positions), width_(attribute.stored_width) {}

    /// Adds each value's prediction by one method.
    void add(Stream& stream, int method);

private:
    std::span<std::int32_t> value(std::size_t i) { return std::span(attribute_.stored).subspan(i * width_, width_); }
    /// The value before another; zeros before the first.
    std::span<const std::int32_t> before(std::size_t i) {
        if (i) return value(i - 1);
        zeros_.assign(width_, 0);
        return zeros_;
    }
    [[nodiscard]] std::array<Integer, 3> position_at(std::int32_t c) const {
        const std::int32_t* const p = &positions_.attribute->stored[3 * positions_.sequence->at_corner(c)];
        return {p[0], p[1], p[2]};
    }

    template <class Correction, class F>
    void add_each(const Correction& correction, F predict) {
        for (std::size_t i = 0; i < sequence_.count; ++i) {
            if (i % 65536 == 0) Interruption::check();
            correction.correct(predict(i), value(i));
        }
    }
    bool predict_parallelogram(std::size_t i, std::int32_t c, std::span<std::int32_t> to);
    std::span<const std::int32_t> predict_texture(std::size_t i, std::vector<bool>& orientations);
    [[nodiscard]] std::array<Integer, 3> normal_at(std::int32_t corner) const;

    Attribute& attribute_;
    const Sequence& sequence_;
    const Positions& positions_;
    std::size_t width_;
    std::vector<std::int32_t> zeros_, predicted_;
};

bool Predictor::predict_parallelogram(std::size_t i, std::int32_t c, std::span<std::int32_t> to) {
    const std::int32_t far = sequence_.corners->across(c);
    if (far < 0) return false;
    const std::size_t opposite = sequence_.at_corner(far), a = sequence_.at_corner(Corners::next(far)), b = sequence_.at_corner(Corners::previous(far));
    if (opposite >= i || a >= i || b >= i) return false;
    for (std::size_t k = 0; k < width_; ++k) to[k] = static_cast<std::int32_t>(Integer{value(a)[k]} + value(b)[k] - value(opposite)[k]);
    return true;
}

std::uint64_t root(std::uint64_t square) {
    auto result = static_cast<std::uint64_t>(std::sqrt(static_cast<double>(square)));
    result = std::min<std::uint64_t>(result, std::numeric_limits<std::uint32_t>::max());
    while (result * result > square) --result;
    while (result < std::numeric_limits<std::uint32_t>::max() && (result + 1) * (result + 1) <= square) ++result;
    return result;
}

/// Arithmetic that wraps around, as Draco's does for awkward numbers.
constexpr Integer wrapped_product(Integer a, Integer b) { return static_cast<Integer>(static_cast<std::uint64_t>(a) * static_cast<std::uint64_t>(b)); }
constexpr Integer wrapped_sum(Integer a, Integer b) { return static_cast<Integer>(static_cast<std::uint64_t>(a) + static_cast<std::uint64_t>(b)); }

Integer wrapped_dot(const std::array<Integer, 3>& a, const std::array<Integer, 3>& b) {
    Integer sum = 0;
    for (std::size_t k = 0; k < 3; ++k) sum = wrapped_sum(sum, wrapped_product(a[k], b[k]));
    return sum;
}

std::array<Integer, 3> minus(const std::array<Integer, 3>& a, const std::array<Integer, 3>& b) {
    std::array<Integer, 3> result;
    for (std::size_t k = 0; k < 3; ++k) result[k] = wrapped_sum(a[k], wrapped_product(-1, b[k]));
    return result;
}

/// Whether a product fits into 64 bits.
bool fits(Integer a, Integer b) {
    if (a == std::numeric_limits<Integer>::min() || b == std::numeric_limits<Integer>::min()) return false;
    return b == 0 || std::abs(a) <= std::numeric_limits<Integer>::max() / std::abs(b);
}

/// Places a triangle's third corner on the texture as it lies in space, on one of two sides.
std::span<const std::int32_t> Predictor::predict_texture(std::size_t i, std::vector<bool>& orientations) {
    const std::int32_t c = sequence_.first[i], at_next = Corners::next(c), at_previous = Corners::previous(c);
    const std::size_t next = sequence_.at_corner(at_next), previous = sequence_.at_corner(at_previous);
    if (next >= i || previous >= i) return next < i ? value(next) : before(i);
    const std::array<Integer, 2> n = {value(next)[0], value(next)[1]}, p = {value(previous)[0], value(previous)[1]};
    if (n == p) return value(previous);
    const auto origin = position_at(at_next), tip = position_at(c), edge = minus(position_at(at_previous), origin);
    const Integer square = wrapped_dot(edge, edge);
    if (square == 0) return value(next);
    const Integer along = wrapped_dot(edge, minus(tip, origin));
    const std::array<Integer, 2> across = {p[0] - n[0], p[1] - n[1]};
    bool is_small = square > 0;
    for (std::size_t k = 0; k < 2; ++k) is_small = is_small && fits(n[k], square) && fits(along, across[k]);
    for (std::size_t k = 0; k < 3; ++k) is_small = is_small && fits(along, edge[k]);
    if (!is_small || orientations.empty()) refuse_values();
    std::array<Integer, 3> foot;
    for (std::size_t k = 0; k < 3; ++k) foot[k] = wrapped_sum(origin[k], along * edge[k] / square);
    const auto height = minus(tip, foot);
    const auto length = static_cast<Integer>(root(static_cast<std::uint64_t>(wrapped_product(wrapped_dot(height, height), square))));
    const Integer sign = orientations.back() ? 1 : -1;
    orientations.pop_back();
    predicted_.resize(2);
    for (std::size_t k = 0; k < 2; ++k) {
        const Integer line = wrapped_sum(n[k] * square, along * across[k]), side = wrapped_product(k ? -across[0] : across[1], length);
        predicted_[k] = static_cast<std::int32_t>(wrapped_sum(line, wrapped_product(sign, side)) / square);
    }
    return predicted_;
}

/// The sum of the normals of all triangles around a corner's vertex, as long as their areas.
std::array<Integer, 3> Predictor::normal_at(std::int32_t corner) const {
    const auto middle = position_at(corner);
    std::array<Integer, 3> sum{};
    sequence_.corners->around(corner, [&](std::int32_t c) {
        const auto a = minus(position_at(Corners::next(c)), middle), b = minus(position_at(Corners::previous(c)), middle);
        for (std::size_t k = 0; k < 3; ++k) {
            const std::size_t l = (k + 1) % 3, m = (k + 2) % 3;
            sum[k] = wrapped_sum(sum[k], wrapped_sum(wrapped_product(a[l], b[m]), wrapped_product(-1, wrapped_product(a[m], b[l]))));
        }
        return true;
    });
    constexpr std::uint64_t most = std::numeric_limits<Integer>::max();
    constexpr Integer bound = Integer{1} << 29;
    std::uint64_t length = 0;
    for (const Integer part : sum) length = std::min(length + (part < 0 ? 0 - static_cast<std::uint64_t>(part) : static_cast<std::uint64_t>(part)), most);
    if (length > static_cast<std::uint64_t>(bound)) {
        for (Integer& part : sum) part /= static_cast<Integer>(length) / bound;
    }
    return sum;
}

void Predictor::add(Stream& stream, int method) {
    const bool is_octahedral = attribute_.coding == unit_vectors;
    const bool is_mesh = sequence_.corners;
    const bool has_positions = positions_.attribute && positions_.attribute->stored_width == 3 && positions_.sequence->corners;
    // Without triangles, each value is predicted by the one before it.
    if (!is_mesh && method > difference) method = difference;
    if ((method == by_texture || method == by_geometry) && !has_positions) refuse_values();
    if (is_octahedral) {
        Octahedron octahedron;
        octahedron.read(stream);
        if (method == difference) return add_each(octahedron, [&](std::size_t i) { return before(i); });
        if (method != by_geometry) refuse_values();
        AnsBits flips(stream);
        std::array<std::int32_t, 2> place;
        return add_each(octahedron, [&](std::size_t i) {
            const auto normal = normal_at(sequence_.first[i]);
            place = octahedron.place_of(normal, flips.read());
            return std::span<const std::int32_t>(place);
        });
    }
    Wrap wrap;
    if (method == difference) {
        wrap.read(stream);
        add_each(wrap, [&](std::size_t i) { return before(i); });
    } else if (method == parallelogram) {
        wrap.read(stream);
        predicted_.resize(width_);
        add_each(wrap, [&](std::size_t i) { return i && predict_parallelogram(i, sequence_.first[i], predicted_) ? std::span<const std::int32_t>(predicted_) : before(i); });
    } else if (method == parallelograms) {
        constexpr std::size_t most = 4;
        std::array<std::vector<bool>, most> creases;  // by the number of parallelograms; in their order
        for (auto& flags : creases) {
            const std::uint32_t count = stream.varint();
            if (count > sequence_.corners->vertex.size()) refuse_values();
            if (!count) continue;
            AnsBits bits(stream);
            flags.resize(count);
            for (std::size_t i = 0; i < count; ++i) flags[i] = bits.read();
        }
        wrap.read(stream);
        std::array<std::size_t, most> used{};
        std::array<std::vector<std::int32_t>, most> candidates;
        for (auto& candidate : candidates) candidate.resize(width_);
        add_each(wrap, [&](std::size_t i) {
            std::size_t count = 0, chosen = 0;
            if (i) {
                sequence_.corners->around(sequence_.first[i], [&](std::int32_t c) {
                    count += predict_parallelogram(i, c, candidates[count]);
                    return count < most;
                });
            }
            predicted_.assign(width_, 0);
            for (std::size_t k = 0; k < count; ++k) {
                if (used[count - 1] >= creases[count - 1].size()) refuse_values();
                if (creases[count - 1][used[count - 1]++]) continue;
                ++chosen;
                for (std::size_t j = 0; j < width_; ++j) {
                    predicted_[j] = static_cast<std::int32_t>(static_cast<std::uint32_t>(predicted_[j]) + static_cast<std::uint32_t>(candidates[k][j]));
                }
            }
            if (!chosen) return before(i);
            for (std::int32_t& number : predicted_) number /= static_cast<std::int32_t>(chosen);
            return std::span<const std::int32_t>(predicted_);
        });
    } else if (method == by_texture && width_ == 2) {
        const auto count = stream.number<std::int32_t>();
        if (count < 0 || static_cast<std::size_t>(count) > sequence_.corners->vertex.size()) refuse_values();
        AnsBits bits(stream);
        std::vector<bool> orientations(static_cast<std::size_t>(count));
        bool last = true;
        for (std::size_t i = 0; i < orientations.size(); ++i) orientations[i] = last = bits.read() ? last : !last;
        wrap.read(stream);
        add_each(wrap, [&](std::size_t i) { return predict_texture(i, orientations); });
    } else {
        refuse_values();
    }
}

}  // namespace

void add_predictions(Stream& stream, int method, Attribute& attribute, const Sequence& sequence, const Positions& positions) {
    Predictor(attribute, sequence, positions).add(stream, method);
}

}  // namespace bob::files::draco
