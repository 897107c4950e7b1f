#include "files/draco_attributes.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <span>

#include "base/interruption.h"
#include "files/draco_entropy.h"
#include "files/text.h"

namespace bob::files::draco {
namespace {

using Integer = std::int64_t;

enum Coding : std::uint8_t { plain_numbers, integers, quantized, unit_vectors };

constexpr std::size_t max_attributes = 256;

[[noreturn]] void refuse_values() { refuse({"expected values of a known kind, got others"}); }

/// Bytes of a number by its type: 1 to 6 are integers, of which odd ones are signed.
std::size_t size_of(int type) {
    constexpr std::size_t sizes[] = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8, 1};
    return sizes[type - 1];
}

constexpr int float32 = 9, float64 = 10;

double number_at(const std::uint8_t* from, int type) {
    switch (type) {
        case 1: return load<std::int8_t>(from, false);
        case 3: return load<std::int16_t>(from, false);
        case 4: return load<std::uint16_t>(from, false);
        case 5: return load<std::int32_t>(from, false);
        case 6: return load<std::uint32_t>(from, false);
        case 7: return static_cast<double>(load<std::int64_t>(from, false));
        case 8: return static_cast<double>(load<std::uint64_t>(from, false));
        case float32: return load<float>(from, false);
        case float64: return load<double>(from, false);
        default: return *from;
    }
}

/// A walk over triangles.
class Walk {
public:
    explicit Walk(const Corners& corners) : corners_(corners), is_met_(corners.leftmost.size()), is_done_(corners.vertex.size() / 3) {
        result_.corners = &corners;
        result_.value_of.resize(corners.leftmost.size());
        result_.first.reserve(corners.leftmost.size());
    }

    void depth_first();
    void by_degree();

    [[nodiscard]] Sequence result() && {
        result_.count = result_.first.size();
        return std::move(result_);
    }

private:
    static constexpr auto next = Corners::next, previous = Corners::previous;

    bool is_done(std::int32_t c) const { return c < 0 || is_done_[static_cast<std::size_t>(c) / 3]; }
    void finish(std::int32_t c) {
        if (++finished_ % 65536 == 0) Interruption::check();
        is_done_[static_cast<std::size_t>(c) / 3] = true;
    }
    bool is_met(std::int32_t c) const { return is_met_[static_cast<std::size_t>(corners_.vertex_of(c))]; }
    void meet(std::int32_t c) {
        const auto vertex = static_cast<std::size_t>(corners_.vertex_of(c));
        if (is_met_[vertex]) return;
        is_met_[vertex] = true;
        result_.value_of[vertex] = static_cast<std::int32_t>(result_.first.size());
        result_.first.push_back(c);
    }
    std::int32_t to_right(std::int32_t c) const { return corners_.across(next(c)); }
    std::int32_t to_left(std::int32_t c) const { return corners_.across(previous(c)); }

    const Corners& corners_;
    std::vector<bool> is_met_, is_done_;  // of vertices and triangles
    std::size_t finished_ = 0;
    Sequence result_;
};

void Walk::depth_first() {
    std::vector<std::int32_t> stack;
    for (std::int32_t start = 0; start < static_cast<std::int32_t>(corners_.vertex.size()); start += 3) {
        if (is_done(start)) continue;
        stack.assign(1, start);
        meet(next(start));
        meet(previous(start));
        while (!stack.empty()) {
            std::int32_t c = stack.back();
            if (is_done(c)) {
                stack.pop_back();
                continue;
            }
            while (true) {
                finish(c);
                if (!is_met(c)) {
                    meet(c);
                    if (!corners_.is_on_boundary(corners_.vertex_of(c))) {
                        c = to_right(c);
                        if (c < 0) refuse_values();
                        continue;
                    }
                }
                const std::int32_t right = to_right(c), left = to_left(c);
                if (is_done(right) && is_done(left)) {
                    stack.pop_back();
                    break;
                }
                if (!is_done(right) && !is_done(left)) {
                    stack.back() = left;
                    stack.push_back(right);
                    break;
                }
                c = is_done(right) ? left : right;
            }
        }
    }
}

void Walk::by_degree() {
    std::array<std::vector<std::int32_t>, 3> stacks;  // by priority
    std::vector<int> degrees(corners_.leftmost.size());
    std::size_t best = 0;
    const auto priority = [&](std::int32_t c) -> std::size_t {
        if (is_met(c)) return 0;
        return ++degrees[static_cast<std::size_t>(corners_.vertex_of(c))] > 1 ? 1 : 2;
    };
    const auto push = [&](std::int32_t c, std::size_t level) {
        stacks[level].push_back(c);
        best = std::min(best, level);
    };
    const auto pop = [&] {
        for (; best < stacks.size(); ++best) {
            if (stacks[best].empty()) continue;
            const std::int32_t c = stacks[best].back();
            stacks[best].pop_back();
            return c;
        }
        return -1;
    };
    for (std::int32_t start = 0; start < static_cast<std::int32_t>(corners_.vertex.size()); start += 3) {
        stacks[0].push_back(start);
        best = 0;
        for (const std::int32_t c : {next(start), previous(start), start}) meet(c);
        for (std::int32_t c = pop(); c >= 0; c = pop()) {
            if (is_done(c)) continue;
            while (true) {
                finish(c);
                meet(c);
                const std::int32_t right = to_right(c), left = to_left(c);
                const bool is_right_done = is_done(right);
                if (!is_done(left)) {
                    const std::size_t level = priority(left);
                    if (is_right_done && level <= best) {
                        c = left;
                        continue;
                    }
                    push(left, level);
                }
                if (is_right_done) break;
                const std::size_t level = priority(right);
                if (level > best) {
                    push(right, level);
                    break;
                }
                c = right;
            }
        }
    }
}

// ---- Corrections of predictions --------------------------------------------------------------------------

/// Integers in an interval, beyond whose ends they go on at the other.
class Wrap {
public:
    void read(Stream& stream) {
        low_ = stream.number<std::int32_t>();
        high_ = stream.number<std::int32_t>();
        if (low_ > high_ || Integer{high_} - low_ >= std::numeric_limits<std::int32_t>::max()) refuse_values();
    }
    /// values: corrections, which become values.
    void correct(std::span<const std::int32_t> predicted, std::span<std::int32_t> values) const {
        const Integer length = Integer{high_} - low_ + 1;
        for (std::size_t k = 0; k < values.size(); ++k) {
            const auto sum = static_cast<std::int32_t>(static_cast<std::uint32_t>(std::clamp(predicted[k], low_, high_)) + static_cast<std::uint32_t>(values[k]));
            values[k] = static_cast<std::int32_t>(sum > high_ ? sum - length : sum < low_ ? sum + length : sum);
        }
    }

private:
    std::int32_t low_ = 0, high_ = 0;
};

/// A square onto which the octahedron of all directions is unfolded, with integer coordinates from 0 to 2 center.
class Octahedron {
public:
    void set_bits(unsigned bits) {
        if (bits < 2 || bits > 30) refuse_values();
        side_ = (Integer{1} << bits) - 1;
        center_ = (side_ - 1) / 2;
    }
    void read(Stream& stream) {
        const auto side = stream.number<std::int32_t>();
        static_cast<void>(stream.number<std::int32_t>());
        if (side < 0 || side % 2 == 0) refuse_values();
        set_bits(static_cast<unsigned>(std::bit_width(static_cast<std::uint32_t>(side))));
    }
    void correct(std::span<const std::int32_t> predicted, std::span<std::int32_t> values) const {
        Place place = {predicted[0] - center_, predicted[1] - center_};
        const bool is_inside = std::abs(place[0]) + std::abs(place[1]) <= center_;
        if (!is_inside) fold(place);
        const int turns = turns_of(place);
        place = turned(place, turns);
        for (std::size_t k = 0; k < 2; ++k) {
            place[k] += values[k];
            place[k] += place[k] > center_ ? -side_ : place[k] < -center_ ? side_ : 0;
        }
        place = turned(place, (4 - turns) % 4);
        if (!is_inside) fold(place);
        for (std::size_t k = 0; k < 2; ++k) values[k] = static_cast<std::int32_t>(place[k] + center_);
    }
    /// The place of a direction, which need not have unit length.
    [[nodiscard]] std::array<std::int32_t, 2> place_of(std::array<Integer, 3> v, bool is_flipped) const {
        const Integer sum = std::abs(v[0]) + std::abs(v[1]) + std::abs(v[2]);
        if (sum == 0) {
            v[0] = center_;
        } else {
            for (std::size_t k = 0; k < 2; ++k) v[k] = v[k] * center_ / sum;
            const Integer rest = center_ - std::abs(v[0]) - std::abs(v[1]);
            v[2] = v[2] >= 0 ? rest : -rest;
        }
        if (is_flipped) v = {-v[0], -v[1], -v[2]};
        Integer s = v[1] + center_, t = v[2] + center_;
        const Integer most = 2 * center_;
        if (v[0] < 0) {
            s = v[1] < 0 ? std::abs(v[2]) : most - std::abs(v[2]);
            t = v[2] < 0 ? std::abs(v[1]) : most - std::abs(v[1]);
        }
        // Each half of an edge of the square is the same as the other half.
        if ((s == 0 && t == 0) || (s == 0 && t == most) || (s == most && t == 0)) {
            s = t = most;
        } else if ((s == 0 && t > center_) || (s == most && t < center_)) {
            t = most - t;
        } else if ((t == most && s < center_) || (t == 0 && s > center_)) {
            s = most - s;
        }
        return {static_cast<std::int32_t>(s), static_cast<std::int32_t>(t)};
    }
    [[nodiscard]] std::array<double, 3> direction(std::int32_t s, std::int32_t t) const {
        double y = static_cast<double>(s) / static_cast<double>(center_) - 1, z = static_cast<double>(t) / static_cast<double>(center_) - 1;
        const double x = 1 - std::fabs(y) - std::fabs(z), over = std::max(-x, 0.0);
        y += y < 0 ? over : -over;
        z += z < 0 ? over : -over;
        const double length = std::sqrt(x * x + y * y + z * z);
        if (length < 1e-3) return {0, 0, 0};
        return {x / length, y / length, z / length};
    }

private:
    using Place = std::array<Integer, 2>;

    /// Exchanges the inside of the diamond and the outside, in the same quarter.
    void fold(Place& place) const {
        auto& [s, t] = place;
        Integer side_s = s > 0 ? 1 : -1, side_t = t > 0 ? 1 : -1;
        if (s >= 0 && t >= 0) side_s = side_t = 1;
        if (s <= 0 && t <= 0 && !(s == 0 && t == 0)) side_s = side_t = -1;
        const Integer corner_s = side_s * center_, corner_t = side_t * center_, from_s = 2 * s - corner_s, from_t = 2 * t - corner_t;
        const bool is_same = side_s * side_t >= 0;
        s = ((is_same ? -from_t : from_t) + corner_s) / 2;
        t = ((is_same ? -from_s : from_s) + corner_t) / 2;
    }
    /// Quarter turns that bring a place to the lower left.
    static int turns_of(const Place& place) {
        const auto [s, t] = place;
        if (s == 0) return t == 0 ? 0 : t > 0 ? 3 : 1;
        if (s > 0) return t >= 0 ? 2 : 1;
        return t <= 0 ? 0 : 3;
    }
    static Place turned(const Place& place, int turns) {
        const auto [s, t] = place;
        return turns == 1 ? Place{t, -s} : turns == 2 ? Place{-s, -t} : turns == 3 ? Place{-t, s} : place;
    }

    Integer side_ = 0, center_ = 0;
};

// ---- Predictions -----------------------------------------------------------------------------------------

enum Prediction : std::int8_t { none = -2, difference = 0, parallelogram = 1, parallelograms = 4, by_texture = 5, by_geometry = 6 };

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

Sequence walk(const Corners& corners, bool is_by_degree) {
    Walk walk(corners);
    if (is_by_degree) {
        walk.by_degree();
    } else {
        walk.depth_first();
    }
    return std::move(walk).result();
}

std::vector<Attribute> read_descriptions(Stream& stream) {
    const std::uint32_t count = stream.varint();
    if (count == 0 || count > max_attributes) refuse({"expected 1 to 256 attributes, got ", std::to_string(count)});
    std::vector<Attribute> result;
    for (std::uint32_t i = 0; i < count; ++i) {
        Attribute attribute{};
        attribute.kind = stream.number();
        attribute.type = stream.number();
        attribute.width = stream.number();
        static_cast<void>(stream.number());  // whether it is normalized, which the accessor says
        attribute.id = stream.varint();
        if (attribute.type < 1 || attribute.type > 11 || attribute.width == 0) refuse_values();
        result.push_back(std::move(attribute));
    }
    for (Attribute& attribute : result) {
        attribute.coding = stream.number();
        const bool is_float = attribute.coding == quantized || attribute.coding == unit_vectors;
        if (attribute.coding > unit_vectors || (is_float && attribute.type != float32)) refuse_values();
        if (attribute.coding == integers && attribute.type > 6) refuse_values();
        if (attribute.coding == unit_vectors && attribute.width != 3) refuse_values();
    }
    return result;
}

void read_stored(Stream& stream, Attribute& attribute, const Sequence& sequence, const Positions& positions, Budget& budget) {
    const std::size_t count = sequence.count;
    budget.take(8 * std::uint64_t{count} * attribute.width);
    if (attribute.coding == plain_numbers) {
        const std::size_t size = size_of(attribute.type);
        const Bytes bytes = stream.take(std::uint64_t{count} * attribute.width * size);
        for (std::size_t at = 0; at < bytes.size(); at += size) attribute.values.push_back(number_at(&bytes[at], attribute.type));
        return;
    }
    const int method = stream.number<std::int8_t>();
    const bool is_octahedral = attribute.coding == unit_vectors;
    if (method != none) {
        const int correction = stream.number<std::int8_t>();
        if (correction != (is_octahedral ? 3 : 1)) refuse_values();
    }
    attribute.stored_width = is_octahedral ? 2 : attribute.width;
    const std::size_t numbers = count * attribute.stored_width;
    if (stream.number()) {
        const std::vector<std::uint32_t> read = symbols(stream, numbers, attribute.stored_width, budget);
        attribute.stored.assign(read.begin(), read.end());
    } else {
        const std::size_t size = stream.number();
        if (size > 4) refuse_values();
        const Bytes bytes = stream.take(std::uint64_t{numbers} * size);
        attribute.stored.resize(numbers);
        for (std::size_t i = 0; i < numbers; ++i) {
            std::uint32_t number = 0;
            for (std::size_t k = 0; k < size; ++k) number |= std::uint32_t{bytes[i * size + k]} << (8 * k);
            attribute.stored[i] = static_cast<std::int32_t>(number);
        }
    }
    if (method == none || !is_octahedral) {
        for (std::int32_t& number : attribute.stored) number = static_cast<std::int32_t>(unzigzagged(static_cast<std::uint32_t>(number)));
    }
    if (method != none) Predictor(attribute, sequence, positions).add(stream, method);
}

void read_values(Stream& stream, Attribute& attribute) {
    const std::vector<std::int32_t>& stored = attribute.stored;
    if (attribute.coding == plain_numbers) return;
    if (attribute.coding == unit_vectors) {
        Octahedron octahedron;
        octahedron.set_bits(stream.number());
        for (std::size_t i = 0; i < stored.size(); i += 2) {
            for (const double number : octahedron.direction(stored[i], stored[i + 1])) attribute.values.push_back(number);
        }
    } else if (attribute.coding == quantized) {
        std::vector<float> lowest;
        for (std::size_t k = 0; k < attribute.width; ++k) lowest.push_back(stream.number<float>());
        const auto range = stream.number<float>();
        const unsigned bits = stream.number();
        if (bits < 1 || bits > 30) refuse_values();
        const float unit = range / static_cast<float>((1u << bits) - 1);
        for (std::size_t i = 0; i < stored.size(); ++i) attribute.values.push_back(static_cast<float>(stored[i]) * unit + lowest[i % attribute.width]);
    } else {
        // Draco keeps the lowest bytes.
        for (const std::int32_t number : stored) {
            std::array<std::uint8_t, 8> bytes{};
            std::memcpy(bytes.data(), &number, sizeof number);
            attribute.values.push_back(number_at(bytes.data(), attribute.type));
        }
    }
}

}  // namespace bob::files::draco
