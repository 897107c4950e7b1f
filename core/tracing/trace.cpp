#include "tracing/trace.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "base/parallel.h"
#include "base/thread_memory.h"
#include "tracing/material.h"
#include "tracing/shade_kernels.h"

namespace bob {
namespace {

/// The first surface along a ray, with the values for the channels.
struct Surface {
    Vec3 normal;  // unit length, in screen space, facing the camera
    float depth;
    std::uint32_t instance;
    Vec3 color;  // of the shape times the material
    const Material* material;
    const Light* light;
};

Vec3 facing_normal(Vec3 normal) {
    // Near silhouettes, interpolated normals lean slightly away from the camera: clamp them to edge-on.
    if (normal.z < 0) normal.z = 0;
    normal = normalized(normal);
    return dot(normal, normal) == 0 ? Vec3{0, 0, 1} : normal;
}

/// The directional light, fixed to the camera, in the screen space of a pixel.
Light light_at(const Projection& projection, float row, float column) {
    const Vec3 direction = projection.turned(Light::of_the_camera().direction, row, column);
    return {direction, normalized(direction + Vec3{0, 0, 1})};
}

/// A pixel, and its index in the list to trace.
struct Numbered {
    Pixel pixel;
    std::uint32_t number;
};

/// Rays traced together, their hits, and the indices of their samples.
struct PixelBatch {
    std::vector<Numbered> pixels;
    std::vector<Ray> rays;
    std::vector<SceneHit> hits;
    std::vector<Vec3> normals, colors;
    std::vector<float> widths;      // pixel footprints of the hits
    std::vector<Surface> surfaces;  // of the hits
    std::vector<std::size_t> sample;
    std::vector<Light> lights;      // per surface, if they differ

    /// Each thread keeps one between calls.
    static PixelBatch& of_this_thread(std::size_t most_rays) {
        PixelBatch& batch = thread_memory<PixelBatch>();
        if (batch.rays.size() < most_rays) {
            batch.sample.resize(most_rays), batch.pixels.resize(most_rays), batch.rays.resize(most_rays), batch.hits.resize(most_rays);
            batch.normals.resize(most_rays), batch.surfaces.resize(most_rays);
            batch.colors.resize(most_rays), batch.widths.resize(most_rays);
            batch.lights.resize(most_rays);
        }
        return batch;
    }
};

void put(Vec3 rgb, float* to) { to[0] = rgb.x, to[1] = rgb.y, to[2] = rgb.z; }

Vec3 product(Vec3 a, Vec3 b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }

/// Writes one channel of the first `count` surfaces to their samples, `width` numbers each, at `place`.
using Write = void (*)(const PixelBatch& batch, std::size_t count, float* samples, std::size_t width, std::size_t place);

template <auto write>
void write_all(const PixelBatch& batch, std::size_t count, float* samples, std::size_t width, std::size_t place) {
    for (std::size_t i = 0; i < count; ++i) write(batch.surfaces[i], samples + batch.sample[i] * width + place);
}

Write writer_of(const Channel& channel) {
    constexpr std::pair<Channel, Write> writers[] = {
        {channels::mask, write_all<[](const Surface&, float* to) { *to = 1; }>},
        {channels::depth, write_all<[](const Surface& s, float* to) { *to = s.depth; }>},
        {channels::normal, write_all<[](const Surface& s, float* to) { to[0] = s.normal.x, to[1] = s.normal.y; }>},
        {channels::albedo, write_all<[](const Surface& s, float* to) { put(s.color, to); }>},
        {channels::alpha, write_all<[](const Surface&, float* to) { *to = 1; }>},
        {channels::shadow, write_all<[](const Surface&, float* to) { *to = 0; }>},
        {channels::variance, write_all<[](const Surface&, float* to) { *to = 0; }>},
        {channels::instance, write_all<[](const Surface& s, float* to) { *to = static_cast<float>(s.instance); }>},
    };
    for (const auto& [written, write] : writers) {
        if (written == channel) return write;
    }
    throw std::invalid_argument("the tracer has no channel " + std::string(channel.name));
}

/// Writes gray and color, which share the lighting, each at its place in a sample; not if that is negative.
void write_shades(const PixelBatch& batch, std::size_t count, float* samples, std::size_t width, int gray, int color) {
    if (gray < 0 && color < 0) return;
    for (std::size_t i = 0; i < count; ++i) {
        const Surface& s = batch.surfaces[i];
        float* const sample = samples + batch.sample[i] * width;
        const Shade shade = shaded(s.normal, s.color, *s.material, *s.light);
        if (gray >= 0) sample[gray] = shade.gray;
        if (color >= 0) put(shade.color, sample + color);
    }
}

/// The position of each of 8 x 8 cells, row by row, along Hilbert's curve.
constexpr std::array<std::uint8_t, 64> along_hilbert_curve = [] {
    std::array<std::uint8_t, 64> places{};
    for (unsigned cell = 0; cell < places.size(); ++cell) {
        unsigned row = cell / 8, column = cell % 8, place = 0;
        for (unsigned half = 4; half; half /= 2) {
            const bool below = row >= half, right = column >= half;
            place += half * half * (right ? (below ? 2 : 3) : (below ? 1 : 0));
            row %= half, column %= half;
            if (below) continue;
            if (right) row = half - 1 - row, column = half - 1 - column;
            std::swap(row, column);
        }
        places[cell] = static_cast<std::uint8_t>(place);
    }
    return places;
}();

/// Sorts pixels by tiles, so that neighbours follow each other. All pixels: tiles of 8 x 8; fewer: tiles with 16 to 64
/// of them on average. Inside tiles, pixels keep their order if they come by tiles, else follow a curve. The result
/// lives until this thread's next call.
std::span<const Numbered> by_tiles(std::span<const Pixel> pixels, int height, int width) {
    const double area = static_cast<double>(height) * width, count = static_cast<double>(pixels.size());
    int log2 = 3;
    while (std::ldexp(count, 2 * log2) < 16 * area && 1 << log2 < std::max(height, width)) ++log2;
    const int across = ((width - 1) >> log2) + 1, down = ((height - 1) >> log2) + 1;
    const auto tile_of = [=](Pixel p) { return static_cast<std::size_t>((p.row >> log2) * across + (p.column >> log2)); };
    const auto cell_of = [=](Pixel p) {
        const int row = p.row >> (log2 - 3) & 7, column = p.column >> (log2 - 3) & 7;
        return along_hilbert_curve[static_cast<std::size_t>(8 * row + column)];
    };
    struct Memory {
        std::vector<std::uint32_t> start;
        std::vector<Numbered> by_cell, by_tile;
    };
    auto& [start, by_cell, by_tile] = thread_memory<Memory>();
    by_tile.resize(pixels.size());
    if (std::is_sorted(pixels.begin(), pixels.end(), [&](Pixel p, Pixel q) { return tile_of(p) < tile_of(q); })) {
        for (std::uint32_t i = 0; i < pixels.size(); ++i) by_tile[i] = {pixels[i], i};
        return by_tile;
    }
    by_cell.resize(pixels.size());
    start.assign(static_cast<std::size_t>(across) * static_cast<std::size_t>(down) + 1, 0);
    std::array<std::uint32_t, along_hilbert_curve.size() + 1> cell_start{};
    for (const Pixel p : pixels) ++start[tile_of(p) + 1], ++cell_start[cell_of(p) + std::size_t{1}];
    std::partial_sum(start.begin(), start.end(), start.begin());
    std::partial_sum(cell_start.begin(), cell_start.end(), cell_start.begin());
    for (std::uint32_t i = 0; i < pixels.size(); ++i) by_cell[cell_start[cell_of(pixels[i])]++] = {pixels[i], i};
    for (const Numbered& p : by_cell) by_tile[start[tile_of(p.pixel)]++] = p;
    return by_tile;
}

/// Traces pixels to samples, batch by batch.
class Tracing {
public:
    Tracing(const Scene& scene, const Camera& camera, int height, int width, const Layout& layout)
        : scene_(scene), projection_(camera, height, width), gray_(layout.place(channels::gray)), color_(layout.place(channels::color)),
          missed_(layout.missed()) {
        for (const Channel& channel : layout) {
            if (channel == channels::gray || channel == channels::color) continue;
            writers_.emplace_back(static_cast<std::size_t>(layout.place(channel)), writer_of(channel));
        }
    }

    [[nodiscard]] std::size_t components() const { return missed_.size(); }

    /// Writes each sample of a batch at its index.
    void operator()(std::span<const Numbered> pixels, float* samples) const {
        constexpr std::size_t ahead = 16;  // samples; sorted pixels rarely find them in the cache
        PixelBatch& batch = PixelBatch::of_this_thread(pixels.size());
        std::size_t count = 0, found = 0;
        for (std::size_t i = 0; i < pixels.size(); ++i) {
            if (i + ahead < pixels.size()) __builtin_prefetch(samples + pixels[i + ahead].number * components(), 1);
            std::copy(missed_.begin(), missed_.end(), samples + pixels[i].number * components());
            if (projection_.ray(pixels[i].pixel, batch.rays[count])) batch.pixels[count++] = pixels[i];
        }
        const std::span<const Ray> rays{batch.rays.data(), count};
        const std::span<const SceneHit> hits{batch.hits.data(), count};
        const std::span<Vec3> normals{batch.normals.data(), count};
        scene_.closest_hits(rays, {batch.hits.data(), count});
        if (!scene_.has_colored_shapes()) {
            scene_.normals(rays, hits, normals);
        } else {
            for (std::size_t j = 0; j < count; ++j) {
                if (batch.hits[j].instance == no_instance) continue;
                const float depth = projection_.depth(rays[j].origin + batch.hits[j].t * rays[j].direction);
                batch.widths[j] = projection_.pixel_width(depth) / length(rays[j].direction);
            }
            scene_.normals_and_colors(rays, hits, {batch.widths.data(), count}, normals, {batch.colors.data(), count});
        }
        for (std::size_t j = 0; j < count; ++j) {
            const SceneHit& hit = batch.hits[j];
            if (hit.instance == no_instance) continue;
            const Vec3 point = rays[j].origin + hit.t * rays[j].direction;
            const auto& [at, number] = batch.pixels[j];
            const auto row = static_cast<float>(at.row), column = static_cast<float>(at.column);
            const Vec3 normal = facing_normal(projection_.on_screen(batch.normals[j], row, column));
            const Light* light = &Light::of_the_camera();
            if (projection_.in_perspective()) {
                batch.lights[found] = light_at(projection_, row, column);
                light = &batch.lights[found];
            }
            const Material& material = scene_[hit.instance].material;
            const Vec3 own = scene_.has_colored_shapes() ? product(material.base_color(), batch.colors[j]) : material.base_color();
            batch.surfaces[found] = {normal, projection_.depth(point), hit.instance, own, &material, light};
            batch.sample[found++] = number;
        }
        for (const auto& [place, write] : writers_) write(batch, found, samples, components(), place);
        write_shades(batch, found, samples, components(), gray_, color_);
    }

private:
    const Scene& scene_;
    Projection projection_;
    std::vector<std::pair<std::size_t, Write>> writers_;
    int gray_, color_;  // places in a sample, or negative
    std::vector<float> missed_;
};

/// Traces `count` pixels, pixel_at(i), which are neighbours in this order, into planes of the `rows` rows from `top` on.
template <class PixelAt>
void trace_sorted(const Scene& scene, const Camera& camera, int height, int width, std::size_t count, PixelAt pixel_at, const Layout& layout,
                  float* planes, int top, int rows) {
    const Tracing tracing(scene, camera, height, width, layout);
    parallel_for(count, batch_size(count), [&](std::size_t begin, std::size_t end) {
        struct Memory {
            std::vector<Numbered> numbered;
            std::vector<Pixel> pixels;
            std::vector<float> samples;
        };
        auto& [numbered, batch, samples] = thread_memory<Memory>();
        numbered.clear(), batch.clear(), samples.resize((end - begin) * tracing.components());
        for (std::size_t i = begin; i < end; ++i) {
            const Pixel pixel = pixel_at(i);
            numbered.push_back({pixel, static_cast<std::uint32_t>(i - begin)});
            batch.push_back({pixel.row - top, pixel.column});
        }
        tracing(numbered, samples.data());
        scatter(layout, batch, samples.data(), tracing.components(), planes, static_cast<std::size_t>(rows), static_cast<std::size_t>(width));
    });
}

}  // namespace

void trace(const Scene& scene, const Camera& camera, int height, int width, std::span<const Pixel> pixels,
           const Layout& layout, float* samples) {
    const Tracing tracing(scene, camera, height, width, layout);
    const std::span<const Numbered> order = by_tiles(pixels, height, width);
    parallel_for(pixels.size(), batch_size(pixels.size()), [&](std::size_t begin, std::size_t end) {
        tracing(order.subspan(begin, end - begin), samples);
    });
}

void trace_into(const Scene& scene, const Camera& camera, int height, int width, std::span<const Pixel> pixels,
                const Layout& layout, float* planes) {
    const std::span<const Numbered> order = by_tiles(pixels, height, width);
    trace_sorted(scene, camera, height, width, pixels.size(), [=](std::size_t i) { return order[i].pixel; }, layout, planes, 0, height);
}

void trace_rows(const Scene& scene, const Camera& camera, int height, int width, int begin, int end, const Layout& layout, float* planes, int top,
                int rows) {
    constexpr std::size_t side = 8;  // of tiles: neighbours follow each other
    const auto across = static_cast<std::size_t>(width), down = static_cast<std::size_t>(std::max(0, end - begin)), strip = side * across;
    const auto pixel = [=](std::size_t i) {
        const std::size_t y = i / strip * side, deep = std::min(side, down - y), in_strip = i % strip;
        const std::size_t x = in_strip / (deep * side) * side, wide = std::min(side, across - x), in_tile = in_strip - x * deep;
        return Pixel{begin + static_cast<int>(y + in_tile / wide), static_cast<int>(x + in_tile % wide)};
    };
    trace_sorted(scene, camera, height, width, down * across, pixel, layout, planes, top, rows);
}

Shading::Shading(const Scene& scene, const Camera& camera, int height, int width, const Layout& layout, float* planes)
    : scene_(scene), projection_(camera, height, width), eye_(projection_.eye()), width_(static_cast<std::size_t>(width)),
      pixels_(static_cast<std::size_t>(height) * width_), albedo_(nullptr), color_(nullptr) {
    const auto plane = [&](const Channel& channel) { return planes + static_cast<std::size_t>(layout.place_of(channel)) * pixels_; };
    depth_ = plane(channels::depth), normal_x_ = plane(channels::normal), normal_y_ = normal_x_ + pixels_, instance_ = plane(channels::instance);
    gray_ = plane(channels::gray);
    if (layout.place(channels::color) >= 0) color_ = plane(channels::color), albedo_ = plane(channels::albedo);
}

void Shading::operator()(int row) const {
    const std::size_t first = static_cast<std::size_t>(row) * width_, end = first + width_;
    std::fill(gray_ + first, gray_ + end, 0.f);
    for (std::size_t k = 0; color_ && k < 3; ++k) std::fill(color_ + k * pixels_ + first, color_ + k * pixels_ + end, 0.f);
    // Runs of pixels of one instance, and the gaps between them.
    for (std::size_t i = first; i < end;) {
        if (depth_[i] == 0) {
            ++i;
            continue;
        }
        std::size_t last = i;
        for (std::size_t j = i + 1; j < end && (depth_[j] == 0 || instance_[j] == instance_[i]); ++j) {
            if (depth_[j] != 0) last = j;
        }
        const Material& material = scene_[static_cast<std::uint32_t>(instance_[i])].material;
        const auto column = static_cast<int>(i - first), count = static_cast<int>(last + 1 - i);
        const bool is_alike = !material.is_physical() && !material.emits() && material.shininess == std::floor(material.shininess);
        is_alike ? shade_alike(material, row, column, count) : shade(material, row, column, count);
        i = last + 1;
    }
}

void Shading::shade(const Material& material, int row, int column, int count) const {
    const std::size_t first = static_cast<std::size_t>(row) * width_ + static_cast<std::size_t>(column);
    for (std::size_t i = first; i < first + static_cast<std::size_t>(count); ++i) {
        if (depth_[i] == 0) continue;
        const Light light = projection_.in_perspective()
                                ? light_at(projection_, static_cast<float>(row), static_cast<float>(i - first) + static_cast<float>(column))
                                : Light::of_the_camera();
        const Vec3 own = albedo_ ? Vec3{albedo_[i], albedo_[pixels_ + i], albedo_[2 * pixels_ + i]} : material.base_color();
        const Shade shade = shaded(whole_normal(normal_x_[i], normal_y_[i]), own, material, light);
        gray_[i] = shade.gray;
        if (color_) color_[i] = shade.color.x, color_[pixels_ + i] = shade.color.y, color_[2 * pixels_ + i] = shade.color.z;
    }
}

void Shading::shade_alike(const Material& material, int row, int column, int count) const {
    constexpr int most = 128, beyond = max_lanes;
    float body[most + beyond], highlight[most + beyond], normal_x[most + beyond], normal_y[most + beyond];
    const auto rounded = [](double value) { return Material::rounded(value); };
    const WholePhong phong{rounded(material.ambient), rounded(material.diffuse), rounded(material.specular), static_cast<unsigned>(material.shininess)};
    float luminances[most];
    std::fill_n(luminances, most, luminance(material.base_color()));
    for (int done = 0; done < count; done += most) {
        const int now = std::min(most, count - done);
        const std::size_t i = static_cast<std::size_t>(row) * width_ + static_cast<std::size_t>(column + done);
        std::copy_n(normal_x_ + i, now, normal_x), std::copy_n(normal_y_ + i, now, normal_y);
        std::fill_n(normal_x + now, beyond, 0.f), std::fill_n(normal_y + now, beyond, 0.f);
        best_shade_kernels().blinn_phong(eye_, phong, Light::of_the_camera().direction, row, column + done, now, normal_x, normal_y, body, highlight);
        const auto put = [&](const float* own, float* to) {
            for (std::size_t k = 0; k < static_cast<std::size_t>(now); ++k) {
                const float shade = std::clamp(own[k] * body[k] + highlight[k], 0.f, 1.f);
                to[i + k] = depth_[i + k] == 0 ? 0.f : shade;
            }
        };
        for (std::size_t k = 0; albedo_ && k < static_cast<std::size_t>(now); ++k) {
            luminances[k] = luminance({albedo_[i + k], albedo_[pixels_ + i + k], albedo_[2 * pixels_ + i + k]});
        }
        put(luminances, gray_);
        for (std::size_t k = 0; albedo_ && k < 3; ++k) put(albedo_ + k * pixels_ + i, color_ + k * pixels_);
    }
}

}  // namespace bob
