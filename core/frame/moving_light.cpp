#include "frame/moving_light.h"

#include <algorithm>

#include "completion/guided.h"
#include "light/edges.h"

namespace bob {

void MovingLight::look_at_edges(int rays) {
    if (rays_ == rays) return;
    rays_ = rays;
    hits_.resize(edges_.size() * hits_of_edge() * first_hit::count);
    lighting_.first_hits_within(camera_, height_, width_, edges_, rays, hits_.data());
}

void MovingLight::move(const Camera& camera, int height, int width) {
    camera_ = camera, height_ = height, width_ = width;
    ++moves_, frames_ = 0, is_at_rest_ = false;
    planes_.resize(first_hit::count * pixels());
    lighting_.first_hits(camera, height, width, planes_.data());
    edges_ = edges_between_surfaces(planes_.data(), height, width);
    rays_ = 0;
    look_at_edges(moving_edge_rays);
    if (!history_) history_.emplace(height, width);
    history_->move(camera, height, width, surfaces());
    begin_drawing();
}

void MovingLight::begin_drawing() {
    drawn_.assign(pixels(), 0), wanted_.assign(pixels(), 0);
    left_ = 0, is_noise_known_ = false;
    for (std::size_t i = 0; i < pixels(); ++i) left_ += wanted_[i] = shows_something(i);
}

void MovingLight::wait_for_more(const std::vector<float>& noise) {
    is_noise_known_ = true;
    for (std::size_t i = 0; i < pixels(); ++i) {
        if (!(noise[i] > visible_noise)) continue;
        wanted_[i] = noisy_passes * drawn_[i];
        left_ += waits(i);
    }
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
    std::vector<Wanted> wanted;
    if (is_noise_known_ && left_ > 0) {  // pass by pass
        std::uint32_t fewest = ~0u;
        for (std::size_t i = 0; i < pixels(); ++i) {
            if (waits(i)) fewest = std::min(fewest, drawn_[i]);
        }
        for (std::size_t i = 0; i < pixels() && wanted.size() < count; ++i) {
            if (waits(i) && drawn_[i] == fewest) wanted.push_back({{static_cast<int>(i) / width_, static_cast<int>(i) % width_}, fewest});
        }
        return wanted;
    }
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

std::size_t MovingLight::trace_next(std::size_t count) {
    const std::vector<Wanted> wanted = next(count);
    std::vector<LightHistory::Traced> traced(wanted.size());
    trace(lighting_, camera_, height_, width_, wanted, paths, seed(), traced.data());
    add(wanted, traced);
    return wanted.size();
}

void MovingLight::add(std::span<const Wanted> wanted, std::span<const LightHistory::Traced> traced) {
    std::vector<Pixel> added;
    for (std::size_t k = 0; k < wanted.size(); ++k) {
        const Pixel pixel = wanted[k].pixel;
        const std::size_t i = static_cast<std::size_t>(pixel.row) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(pixel.column);
        const bool waited = waits(i);
        drawn_[i] += traced[k].paths;
        left_ -= waited && !waits(i);
        added.push_back(pixel);
    }
    history_->add(added, traced, is_at_rest_, surfaces());
}

void MovingLight::write(float* planes) const { history_->write(surfaces(), planes); }

void MovingLight::complete(bool is_smooth, float* color, float* alpha) {
    static const Layout guides{channels::mask, channels::depth, channels::normal, channels::albedo};
    const Layout& layout = LightHistory::layout();
    const float* const ground = surfaces().ground;
    const bool asks_for_noise = is_at_rest_ && left_ == 0 && !is_noise_known_;
    std::vector<float> planes(LightHistory::plane_count * pixels()), noise(asks_for_noise ? pixels() : 0);
    write(planes.data());
    complete_light(layout, planes.data(), guides, planes_.data(), ground, height_, width_, color, alpha, asks_for_noise ? noise.data() : nullptr,
                   is_at_rest_);
    if (asks_for_noise) wait_for_more(noise);
    if (is_smooth) smooth_edges(edges_, hits_.data(), hits_of_edge(), planes_.data(), ground, height_, width_, color, alpha);
}

void MovingLight::write_mask(float* mask) const {
    for (std::size_t i = 0; i < pixels(); ++i) mask[i] = drawn_[i] > 0 || !shows_something(i) ? 1.f : 0.f;
}

}  // namespace bob
