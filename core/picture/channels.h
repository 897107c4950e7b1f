/// Channels: what is known of a pixel, each declared once, and the layouts that list them.
#pragma once

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "base/vec.h"

namespace bob {

struct Channel {
    std::string_view name;
    int components;
    float low, high;   // range of the values
    float missed = 0;  // the value of all components where a ray missed, unless what is there is seen
    bool seen = false; // also of what lies behind all surfaces, which may shine: a sample's own value where its ray missed

    bool operator==(const Channel& other) const { return name == other.name; }
};

namespace channels {

/// 1 where a ray was traced. In a sample it says instead whether the ray hit.
inline constexpr Channel mask{"mask", 1, 0, 1};
/// Blinn-Phong shade, display-referred.
inline constexpr Channel gray{"gray", 1, 0, 1, 0, true};
/// 1 at the point of the unit sphere nearest the camera, 0 at the farthest.
inline constexpr Channel depth{"depth", 1, 0, 1};
/// x right and y up, in screen space; of unit length together with a z >= 0 towards the camera.
inline constexpr Channel normal{"normal", 2, -1, 1};

/// Linear RGB, display-referred; gray is its luminance.
inline constexpr Channel color{"color", 3, 0, 1, 0, true};
/// Linear RGB of the surface itself: what the light is multiplied by.
inline constexpr Channel albedo{"albedo", 3, 0, 1};
/// 1 where a surface was hit.
inline constexpr Channel alpha{"alpha", 1, 0, 1};

/// Which of the scene's instances was hit: its place in the canonical order.
inline constexpr Channel instance{"instance", 1, 0, 100000};

/// How much light the ground lacks that a scene casts its shadow on, of the share of a pixel that shows it.
inline constexpr Channel shadow{"shadow", 1, 0, 1, 0, true};

/// How uncertain the gray is, of tracers that draw at random: the variance of its mean; 0 where it is exact.
inline constexpr Channel variance{"variance", 1, 0, std::numeric_limits<float>::infinity(), 0, true};

inline constexpr Channel all[] = {mask, gray, depth, normal, color, albedo, alpha, instance, shadow, variance};

}  // namespace channels

/// Of the two components of the channel `normal`.
inline Vec3 whole_normal(float x, float y) { return {x, y, std::sqrt(std::max(0.f, 1 - x * x - y * y))}; }

/// Which channels an array holds, in which order: planes (width, H, W), or samples (n, width).
class Layout {
public:
    Layout(std::initializer_list<Channel> channels) : channels_(channels) {}

    /// From names with commas between them. Throws std::invalid_argument if there is no such channel.
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

    /// Components of all channels.
    [[nodiscard]] int width() const {
        int sum = 0;
        for (const Channel& channel : channels_) sum += channel.components;
        return sum;
    }

    /// Where a channel's first component is, or -1 where the layout lacks it.
    [[nodiscard]] int place(const Channel& wanted) const {
        int at = 0;
        for (const Channel& channel : channels_) {
            if (channel == wanted) return at;
            at += channel.components;
        }
        return -1;
    }

    /// The same, of a channel that must be there: throws std::invalid_argument.
    [[nodiscard]] int place_of(const Channel& wanted) const {
        const int at = place(wanted);
        if (at < 0) {
            throw std::invalid_argument("expected a G-buffer with the channel " + std::string(wanted.name) + ", got one with " +
                                        names());
        }
        return at;
    }

    /// Where a ray missed: the value of each component.
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

/// What the tracer finds at a pixel, and a G-buffer holds. The mask comes first.
inline const Layout& gbuffer_layout() {
    static const Layout layout{channels::mask, channels::gray, channels::depth, channels::normal};
    return layout;
}

/// The same of scenes with colours: what reads the layout above from planes of this one finds its own.
inline const Layout& colored_layout() {
    static const Layout layout{channels::mask, channels::gray, channels::depth, channels::normal, channels::color};
    return layout;
}

/// What else a moving camera remembers, to shade anew what another one has seen: behind one of the layouts above.
inline const Layout& remembered_layout(bool is_colored) {
    static const Layout gray{channels::mask, channels::gray, channels::depth, channels::normal, channels::instance};
    static const Layout colored{channels::mask, channels::gray, channels::depth, channels::normal,
                                channels::color, channels::albedo, channels::instance};
    return is_colored ? colored : gray;
}

}  // namespace bob
