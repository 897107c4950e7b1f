/// Channels of a pixel, each declared once, and layouts that list them.
#pragma once

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "base/counts.h"
#include "base/vec.h"

namespace bob {

struct Channel {
    std::string_view name;
    int components;
    float low, high;   // range of the values
    float missed = 0;  // value of all components for a miss, unless `seen`
    bool seen = false; // also visible behind all surfaces, which may shine: a miss keeps its sample's value

    bool operator==(const Channel& other) const { return name == other.name; }
};

namespace channels {

/// 1 where a ray was traced. In a sample, 1 for a hit and 0 for a miss.
inline constexpr Channel mask{"mask", 1, 0, 1};
/// Blinn-Phong shade, display-referred.
inline constexpr Channel gray{"gray", 1, 0, 1, 0, true};
/// 1 at the unit sphere's nearest point to the camera, 0 at its farthest.
inline constexpr Channel depth{"depth", 1, 0, 1};
/// x right and y up, in screen space; z >= 0 towards the camera completes it to unit length.
inline constexpr Channel normal{"normal", 2, -1, 1};

/// Linear RGB, display-referred; gray is its luminance.
inline constexpr Channel color{"color", 3, 0, 1, 0, true};
/// Linear RGB reflectance of the surface: the factor of the light.
inline constexpr Channel albedo{"albedo", 3, 0, 1};
/// 1 where a surface was hit.
inline constexpr Channel alpha{"alpha", 1, 0, 1};

/// The instance that was hit, as its index in the canonical order.
inline constexpr Channel instance{"instance", 1, 0, static_cast<float>(max_instances)};

/// Shadow of a scene on the ground. It is the missing share of light, times the share of the pixel that shows the
/// ground.
inline constexpr Channel shadow{"shadow", 1, 0, 1, 0, true};

/// Variance of the mean gray, for stochastic tracers; 0 where it is exact.
inline constexpr Channel variance{"variance", 1, 0, std::numeric_limits<float>::infinity(), 0, true};

inline constexpr Channel all[] = {mask, gray, depth, normal, color, albedo, alpha, instance, shadow, variance};

}  // namespace channels

/// The unit normal with the two components of the channel `normal`.
inline Vec3 whole_normal(float x, float y) { return {x, y, std::sqrt(std::max(0.f, 1 - x * x - y * y))}; }

/// The channels of an array, in order: planes (width, H, W), or samples (n, width).
class Layout {
public:
    Layout(std::initializer_list<Channel> channels) : channels_(channels) {}

    /// Reads names separated by commas. Throws std::invalid_argument if a channel does not exist.
    explicit Layout(std::string_view names) {
        for (std::size_t begin = 0; begin <= names.size();) {
            const std::size_t end = std::min(names.find(',', begin), names.size());
            const std::string_view name = names.substr(begin, end - begin);
            const auto* found = std::find_if(std::begin(channels::all), std::end(channels::all),
                                             [&](const Channel& channel) { return channel.name == name; });
            if (found == std::end(channels::all)) {
                throw std::invalid_argument("expected channels among " + Layout(channels::all).names() + ", got '" +
                                            std::string(name) + "'");
            }
            channels_.push_back(*found);
            begin = end + 1;
        }
    }

    [[nodiscard]] std::string names() const {
        std::string result;
        for (const Channel& channel : channels_) {
            if (!result.empty()) result += ',';
            result += channel.name;
        }
        return result;
    }

    /// Number of components of all channels.
    [[nodiscard]] int width() const {
        int sum = 0;
        for (const Channel& channel : channels_) sum += channel.components;
        return sum;
    }

    /// The index of a channel's first component, or -1 if the layout lacks it.
    [[nodiscard]] int place(const Channel& wanted) const {
        int at = 0;
        for (const Channel& channel : channels_) {
            if (channel == wanted) return at;
            at += channel.components;
        }
        return -1;
    }

    /// The same for a required channel: throws std::invalid_argument.
    [[nodiscard]] int place_of(const Channel& wanted) const {
        const int at = place(wanted);
        if (at < 0) {
            throw std::invalid_argument("expected a G-buffer with the channel " + std::string(wanted.name) + ", got one with " +
                                        names());
        }
        return at;
    }

    /// The value of each component for a miss.
    [[nodiscard]] std::vector<float> missed() const {
        std::vector<float> values;
        for (const Channel& channel : channels_) {
            values.insert(values.end(), static_cast<std::size_t>(channel.components), channel.missed);
        }
        return values;
    }

    [[nodiscard]] auto begin() const { return channels_.begin(); }
    [[nodiscard]] auto end() const { return channels_.end(); }
    bool operator==(const Layout&) const = default;

private:
    template <std::size_t N>
    explicit Layout(const Channel (&channels)[N]) : channels_(std::begin(channels), std::end(channels)) {}

    std::vector<Channel> channels_;
};

/// The channels of a G-buffer, mask first.
inline const Layout& gbuffer_layout() {
    static const Layout layout{channels::mask, channels::gray, channels::depth, channels::normal};
    return layout;
}

/// The same for scenes with colours; planes of this layout begin with planes of the one above.
inline const Layout& colored_layout() {
    static const Layout layout{channels::mask, channels::gray, channels::depth, channels::normal, channels::color};
    return layout;
}

/// The layouts above, followed by the channels that shading a reprojected picture needs.
inline const Layout& remembered_layout(bool is_colored) {
    static const Layout gray{channels::mask, channels::gray, channels::depth, channels::normal, channels::instance};
    static const Layout colored{channels::mask, channels::gray, channels::depth, channels::normal,
                                channels::color, channels::albedo, channels::instance};
    return is_colored ? colored : gray;
}

}  // namespace bob
