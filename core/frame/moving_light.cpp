#include "frame/moving_light.h"

#include <algorithm>

#include "completion/guided.h"
#include "light/edges.h"

namespace bob {

void MovingLight::look_at_edges(int rays) {
    if (rays_ == rays) return;
    rays_ = rays;
    const auto side = static_cast<std::size_t>(rays);
    hits_.resize(edges_.size() * side * side * first_hit::count);
    lighting_.first_hits_within(camera_, height_, width_, edges_, rays, hits_.data());
}

void MovingLight::move(const Camera& camera, int height, int width) {
    const bool is_first = !history_;
    camera_ = camera, height_ = height, width_ = width;
    ++moves_, frames_ = 0, is_at_rest_ = false;
    planes_.resize(first_hit::count * pixels());
    lighting_.first_hits(camera, height, width, planes_.data());
    edges_ = edges_between_surfaces(planes_.data(), height, width);
    rays_ = 0;
    look_at_edges(is_first ? edge_rays : moving_edge_rays);
    if (is_first) history_.emplace(height, width);
    history_->move(camera, height, width, surfaces());
    begin_drawing();
}

void MovingLight::begin_drawing() {
    drawn_.assign(pixels(), 0);
    left_ = 0;
    for (std::size_t i = 0; i < pixels(); ++i) left_ += shows_something(i);
}

void MovingLight::rest() {
    if (is_at_rest_) return;
    is_at_rest_ = true, frames_ = 0;
    look_at_edges(edge_rays);
    history_->age();
    begin_drawing();
}

std::vector<MovingLight::Wanted> MovingLight::next(std::size_t count) {
    const auto seed = static_cast<std::uint32_t>(seed_ + frames_++);
    if (is_at_rest_) count = std::min(count, left_);
    std::vector<Wanted> wanted;
    for (const Pixel pixel : history_->next(count, seed, is_at_rest_, surfaces())) {
        const std::size_t i = static_cast<std::size_t>(pixel.row) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(pixel.column);
        wanted.push_back({pixel, drawn_[i]});
    }
    return wanted;
}

void MovingLight::trace(const Lighting& lighting, const Camera& camera, int height, int width, std::span<const Wanted> wanted, std::uint32_t paths,
                        std::uint64_t seed, LightHistory::Traced* traced) {
    const Layout& layout = LightHistory::layout();
    std::vector<Pixel> pixels;
    std::vector<std::uint32_t> drawn;
    for (const auto& [pixel, before] : wanted) pixels.push_back(pixel), drawn.push_back(before);
    std::vector<float> samples(wanted.size() * static_cast<std::size_t>(layout.width())), changes(wanted.size());
    lighting.trace(camera, height, width, pixels, {drawn, paths, seed}, layout, samples.data(), changes.data());
    for (std::size_t k = 0; k < wanted.size(); ++k) {
        traced[k] = LightHistory::Traced::of(samples.data() + k * LightHistory::plane_count, changes[k], paths);
    }
}

void MovingLight::add(std::span<const Wanted> wanted, std::span<const LightHistory::Traced> traced) {
    std::vector<Pixel> added;
    for (std::size_t k = 0; k < wanted.size(); ++k) {
        const Pixel pixel = wanted[k].pixel;
        const std::size_t i = static_cast<std::size_t>(pixel.row) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(pixel.column);
        if (drawn_[i] == 0 && shows_something(i)) --left_;
        drawn_[i] += traced[k].paths;
        added.push_back(pixel);
    }
    history_->add(added, traced, is_at_rest_, surfaces());
}

void MovingLight::complete(bool is_smooth, float* color, float* alpha) const {
    static const Layout guides{channels::mask, channels::depth, channels::normal, channels::albedo};
    static const Layout shadows{channels::mask, channels::gray, channels::variance};
    using P = LightHistory;
    const std::size_t size = pixels();
    std::vector<float> planes(P::plane_count * size);
    history_->write(surfaces(), planes.data());
    complete_guided(P::layout(), planes.data(), guides, planes_.data(), channels::color, height_, width_, true, color);
    const float* const ground = planes_.data() + first_hit::ground * size;
    if (std::any_of(ground, ground + size, [](float share) { return share > 0; })) {
        // Shadows are in gray's place, and the ground is white.
        std::copy_n(planes.data() + P::shadow * size, size, planes.data() + size);
        std::copy_n(planes.data() + P::variance * size, size, planes.data() + 2 * size);
        std::vector<float> flat(7 * size);
        std::copy_n(ground, 2 * size, flat.data());
        for (std::size_t c = 4; c < 7; ++c) std::copy_n(ground, size, flat.data() + c * size);
        complete_guided(shadows, planes.data(), guides, flat.data(), channels::gray, height_, width_, true, alpha);
    } else {
        std::fill_n(alpha, size, 0.f);
    }
    for (std::size_t i = 0; i < size; ++i) alpha[i] = std::min(alpha[i] + planes_[i], 1.f);
    if (!is_smooth) return;
    const auto side = static_cast<std::size_t>(rays_);
    smooth_edges(edges_, hits_.data(), side * side, planes_.data(), ground, height_, width_, color, alpha);
}

void MovingLight::write_mask(float* mask) const {
    for (std::size_t i = 0; i < pixels(); ++i) mask[i] = drawn_[i] > 0 || !shows_something(i) ? 1.f : 0.f;
}

}  // namespace bob
