#include "picture/adaptive.h"

#include <algorithm>
#include <bit>
#include <cstdlib>

namespace bob {
namespace {

/// Where rounds end, in ten-thousandths of the pixels: 8 of them to 5 %, 16 to 25 %, each a constant factor longer than
/// the one before.
constexpr std::uint32_t round_ends[] = {35,  51,  75,   110,  160,  234,  342,  500,  611,  748,  914,  1118,
                                        1367, 1672, 2045, 2500, 2973, 3536, 4204, 5000, 5946, 7071, 8409, 10000};

/// This share of a round, in percent, follows the lattice whatever it shows.
constexpr std::uint32_t exploring = 10;

/// What equal corners are worth, so that larger squares still come first.
constexpr std::uint32_t floor = 5;

/// Of the contrast around a pixel that was chosen and is not known yet, this much in percent is expected around its own
/// children. So one round refines by several levels where much differs.
constexpr std::uint32_t expected = 30;

constexpr std::uint32_t most = 255;

/// A pixel whose gray differs by more from a corner's has something new beside it.
constexpr int news = 32;

/// The four pixels at a step along the axes, or along both.
std::array<Pixel, 4> around(Pixel pixel, std::int32_t step, bool diagonal) {
    const auto [row, column] = pixel;
    const std::int32_t h = step;
    if (diagonal) return {{{row - h, column - h}, {row - h, column + h}, {row + h, column - h}, {row + h, column + h}}};
    return {{{row - h, column}, {row + h, column}, {row, column - h}, {row, column + h}}};
}

std::uint8_t step_of(float value, const Channel& channel) {
    const float share = (value - channel.low) / (channel.high - channel.low);
    return share > 0 ? static_cast<std::uint8_t>(std::min(share, 1.f) * 255 + 0.5f) : 0;  // also of what is no number
}

}  // namespace

AdaptiveOrder::AdaptiveOrder(std::uint64_t seed, std::uint32_t height, std::uint32_t width)
    : height_(height), width_(width), total_(height * width), lattice_(make_order("lattice", seed, height, width)),
      states_(total_, State::open), looks_(total_), queue_of_(total_) {}

AdaptiveOrder::Place AdaptiveOrder::place(Pixel pixel) {
    const auto& [row, column] = lattice_tile().places[0];
    const auto zeros = [](std::int32_t x) { return std::min(std::countr_zero(static_cast<std::uint32_t>(x)), Tile::bits); };
    const int down = zeros(pixel.row - row), right = zeros(pixel.column - column);
    return {1 << std::min(down, right), down == right};
}

std::span<const Pixel> AdaptiveOrder::next(const Layout& layout, const float* planes) {
    read(layout, planes);
    round_.clear();
    if (decided_ == total_) return round_;
    std::uint32_t end = 0;
    while (end <= decided_) {
        end = rounds_ < std::size(round_ends) ? static_cast<std::uint32_t>(std::uint64_t{total_} * round_ends[rounds_] / 10000)
                                              : total_;
        ++rounds_;
    }
    const std::uint32_t count = end - decided_;
    const auto follow_lattice = [&](std::size_t until) {
        while (round_.size() < until && of_lattice_ < total_) {
            Pixel pixel;
            lattice_(of_lattice_++, {&pixel, 1});
            if (states_[index_of(pixel)] == State::open) choose(index_of(pixel));
        }
    };
    follow_lattice(decided_ == 0 ? count : count * exploring / 100);
    for (std::size_t q = queues; q-- > 1 && round_.size() < count;) {
        // Children of what is taken may be put here as well.
        std::vector<std::uint32_t>& queue = waiting_[q];
        std::size_t taken = 0;
        while (taken < queue.size() && round_.size() < count) {
            const std::uint32_t index = queue[taken++];
            if (states_[index] != State::open || queue_of_[index] != q) continue;  // taken, or looked at anew
            const Pixel pixel = pixel_at(index);
            choose(index);
            const Place at = place(pixel);
            const std::uint32_t around_it = contrast(pixel, at.step, !at.diagonal, at.diagonal);
            if (around_it > 0) look_around(index, around_it * expected / 100);
        }
        queue.erase(queue.begin(), queue.begin() + static_cast<std::ptrdiff_t>(taken));
    }
    follow_lattice(count);
    decided_ = end;
    return round_;
}

void AdaptiveOrder::read(const Layout& layout, const float* planes) {
    const auto plane = [&](const Channel& channel, int component = 0) -> const float* {
        const int at = layout.place(channel);
        return at < 0 ? nullptr : planes + static_cast<std::size_t>(at + component) * total_;
    };
    const float *gray = plane(channels::gray), *depth = plane(channels::depth), *x = plane(channels::normal),
                *y = plane(channels::normal, 1);
    for (const Pixel pixel : round_) {
        const std::uint32_t i = index_of(pixel);
        Look& look = looks_[i];
        if (gray) look[0] = step_of(gray[i], channels::gray);
        if (depth) look[1] = depth[i] > 0 ? 255 : 0;
        if (x) look[2] = step_of(x[i], channels::normal);
        if (y) look[3] = step_of(y[i], channels::normal);
        states_[i] = State::traced;
    }
    for (const Pixel pixel : round_) {
        look_around(index_of(pixel), 0);
        look_beside(index_of(pixel));
    }
}

void AdaptiveOrder::choose(std::uint32_t index) {
    states_[index] = State::chosen;
    round_.push_back(pixel_at(index));
}

void AdaptiveOrder::look_around(std::uint32_t index, std::uint32_t least) {
    const Pixel pixel = pixel_at(index);
    const Place at = place(pixel);
    // It is a corner of the middles of the squares around it, or, if it is such a middle itself, of their sides.
    const bool middle = at.diagonal && at.step < static_cast<std::int32_t>(Tile::side);
    const std::int32_t step = middle ? at.step : at.step / 2;
    if (step == 0) return;  // all of them come before it
    for (const Pixel child : around(pixel, step, !middle)) consider(child, {step, !middle}, least);
}

void AdaptiveOrder::look_beside(std::uint32_t index) {
    const Pixel pixel = pixel_at(index);
    const Place at = place(pixel);
    const Look& own = looks_[index];
    bool differs = false;
    for (const Pixel corner : around(pixel, at.step, at.diagonal)) {
        if (!is_inside(corner) || states_[index_of(corner)] != State::traced) continue;
        const Look& other = looks_[index_of(corner)];
        differs = differs || other[1] != own[1] || std::abs(other[0] - own[0]) > news;
    }
    if (!differs) return;
    const auto area = static_cast<std::uint32_t>(at.step * at.step);
    for (const bool diagonal : {false, true}) {
        for (const Pixel beside : around(pixel, at.step, diagonal)) {
            if (!is_inside(beside) || states_[index_of(beside)] != State::open) continue;
            wait(index_of(beside), (contrast(beside, at.step, true, true) + floor) * area, true);
        }
    }
}

void AdaptiveOrder::consider(Pixel pixel, Place at, std::uint32_t least) {
    if (!is_inside(pixel)) return;
    const std::uint32_t index = index_of(pixel);
    if (states_[index] != State::open) return;
    wait(index, (std::max(least, contrast(pixel, at.step, !at.diagonal, at.diagonal)) + floor) * at.area(), false);
}

void AdaptiveOrder::wait(std::uint32_t index, std::uint32_t worth, bool at_least) {
    const int octave = std::bit_width(worth) - 1;
    const auto q = static_cast<std::uint8_t>(8 * octave + static_cast<int>((std::uint64_t{worth} << 3 >> octave) & 7));
    if (queue_of_[index] == q || (at_least && queue_of_[index] > q)) return;
    queue_of_[index] = q;
    waiting_[q].push_back(index);
}

std::uint32_t AdaptiveOrder::contrast(Pixel pixel, std::int32_t step, bool sides, bool corners) const {
    Look low{255, 255, 255, 255}, high{};
    const auto add = [&](Pixel p) {
        if (!is_inside(p)) return;
        const std::uint32_t i = index_of(p);
        if (states_[i] != State::traced) return;
        const Look look = looks_[i];
        low = look < low ? look : low;
        high = look > high ? look : high;
    };
    if (sides) std::ranges::for_each(around(pixel, step, false), add);
    if (corners) std::ranges::for_each(around(pixel, step, true), add);
    if (low[1] > high[1]) return 0;  // nothing is known
    if (low[1] < high[1]) return most;  // silhouette
    const Look range = high - low;
    return std::min(most, range[0] + (static_cast<std::uint32_t>(range[2]) + range[3]) * 5 / 8);
}

std::size_t AdaptiveOrder::bytes() const {
    std::size_t sum = states_.capacity() + queue_of_.capacity() + looks_.capacity() * sizeof(Look) + round_.capacity() * sizeof(Pixel);
    for (const auto& queue : waiting_) sum += queue.capacity() * sizeof(std::uint32_t);
    return sum;
}

}  // namespace bob
