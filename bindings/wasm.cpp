/// Meshes, scenes and pixel orders in the WebAssembly modules: convert and call. The modules of viewer/ check
/// arguments, with better messages; only out-of-bounds accesses are checked here.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/counts.h"
#include "frame/planner.h"
#include "reprojection/history.h"
#include "sampling/adaptive.h"
#include "sampling/order.h"
#include "sampling/refresh.h"
#include "sampling/squares.h"
#include "sampling/whole.h"
#include "shapes/mesh/owned_arrays.h"
#include "tracing/antialiasing.h"
#include "tracing/arrangement.h"
#include "tracing/canonical.h"
#include "tracing/trace.h"
#include "wasm.h"
#include "wasm_shape.h"

namespace {

/// Numbers of a material in the page, in the order of its fields.
constexpr std::size_t of_material = 21;
bob::Material material_of(const double* numbers) {
    bob::Material material;
    static_assert(offsetof(bob::Material, is_thin) == (of_material - 1) * sizeof(double));
    std::memcpy(static_cast<void*>(&material), numbers, (of_material - 1) * sizeof(double));
    material.is_thin = numbers[of_material - 1] != 0;
    return material;
}

std::uint64_t joined(std::uint32_t low, std::uint32_t high) { return std::uint64_t{high} << 32 | low; }

}  // namespace

// ---- Shapes ----------------------------------------------------------------------------------------------

/// A picture, which meshes share. texels: (height, width, 3) in sRGB; alpha: (height, width), or null.
EXPORT(make_picture)
std::shared_ptr<const bob::Picture>* make_picture(const std::uint8_t* texels, std::int32_t height, std::int32_t width,
                                                  const std::uint8_t* alpha) {
    return attempt([&] {
        const std::size_t size = static_cast<std::size_t>(height) * static_cast<std::size_t>(width), of_alpha = alpha ? size : 0;
        auto own = std::make_shared<std::vector<std::uint8_t>>(3 * size + of_alpha);
        std::copy_n(alpha, of_alpha, std::copy_n(texels, 3 * size, own->data()));
        const auto all = std::span<const std::uint8_t>(*own);
        return new std::shared_ptr<const bob::Picture>(
            std::make_shared<bob::Picture>(all.first(3 * size), height, width, all.last(of_alpha), std::move(own)));
    });
}

/// Meshes that use it keep it alive.
EXPORT(free_picture) void free_picture(std::shared_ptr<const bob::Picture>* picture) { delete picture; }

/// Makes a mesh. Optional arrays may be null.
///
/// vertices: (vertex_count, 3); triangles: (triangle_count, 3); normals and, in linear RGB, colors: (vertex_count, 3),
/// optional; face_colors: (triangle_count, 3), optional; uv: (vertex_count, 2), with a picture that wraps across and
/// down, both optional; alphas: (vertex_count,), optional; alpha_cutoff: there is no surface where alphas are lower.
EXPORT(make_mesh)
Shape* make_mesh(const double* vertices, std::size_t vertex_count, const std::int32_t* triangles, std::size_t triangle_count,
                 const float* normals, const float* colors, const float* face_colors, const float* uv,
                 const std::shared_ptr<const bob::Picture>* picture, std::int32_t across, std::int32_t down, const float* alphas,
                 float alpha_cutoff) {
    return attempt([&] {
        expect(triangle_count > 0, "triangles: expected at least one");
        for (const std::int32_t index : std::span(triangles, 3 * triangle_count)) {
            expect(index >= 0 && static_cast<std::size_t>(index) < vertex_count, "triangles: index out of range");
        }
        const auto* points = reinterpret_cast<const bob::Mesh::Point*>(vertices);
        const auto* corners = reinterpret_cast<const bob::Triangle*>(triangles);
        const auto* directions = reinterpret_cast<const bob::Vec3*>(normals);
        const auto own = std::make_shared<bob::OwnedArrays>();
        own->vertices.assign(points, points + vertex_count);
        own->triangles.assign(corners, corners + triangle_count);
        if (normals) own->normals.assign(directions, directions + vertex_count);
        const auto take = [](const float* from, std::size_t count, std::vector<bob::Vec3>& to) {
            const auto* first = reinterpret_cast<const bob::Vec3*>(from);
            if (from) to.assign(first, first + count);
        };
        take(colors, vertex_count, own->colors), take(face_colors, triangle_count, own->face_colors);
        if (picture) {
            const auto* places = reinterpret_cast<const bob::Mesh::Uv*>(uv);
            own->uv.assign(places, places + vertex_count);
            own->texture = std::make_shared<bob::Texture>(*picture, static_cast<bob::Wrap>(across), static_cast<bob::Wrap>(down));
        }
        if (alphas) own->alphas.assign(alphas, alphas + vertex_count);
        own->alpha_cutoff = alpha_cutoff;
        auto mesh = std::make_shared<bob::Mesh>(bob::OwnedArrays::of(own));
        expect(std::isfinite(mesh->sphere().radius), "vertices: expected finite numbers, got NaN or infinite ones");
        return new Shape{std::move(mesh)};
    });
}

/// Writes the unit normals at the corners of a mesh's triangles, (T, 3, 3); returns 0 if that fails.
EXPORT(corner_normals)
bool corner_normals(const Shape* mesh, float* normals) {
    return attempt([&] {
        const auto computed = static_cast<const bob::Mesh&>(*mesh->core).corner_normals();
        std::copy_n(reinterpret_cast<const float*>(computed.data()), 9 * computed.size(), normals);
        return true;
    });
}

/// Whether construction reached its work budget (work.h).
EXPORT(is_coarse) bool is_coarse(const Shape* shape) { return shape->is_coarse; }

/// Scenes that use it keep it alive.
EXPORT(free_shape) void free_shape(Shape* shape) { delete shape; }

// ---- Order -----------------------------------------------------------------------------------------------

EXPORT(make_sha256) bob::Sha256* make_sha256() { return new bob::Sha256; }

EXPORT(add_bytes) void add_bytes(bob::Sha256* hash, const std::byte* bytes, std::size_t size) { hash->update({bytes, size}); }

/// Writes 32 bytes.
EXPORT(end_sha256) void end_sha256(bob::Sha256* hash, std::uint8_t* digest) {
    std::ranges::copy(hash->digest(), digest);
    delete hash;
}

/// Indices of the instances in canonical order. shapes: (count, 32), the digest of each one's shape; transforms:
/// (count, 4, 4); materials: (count, of_material).
EXPORT(canonical_order)
bool canonical_order(const bob::Digest* shapes, const double* transforms, const double* materials, std::size_t count,
                     std::uint32_t* order) {
    return attempt([&] {
        std::vector<bob::Digest> digests;
        for (std::size_t i = 0; i < count; ++i) {
            digests.push_back(bob::instance_digest(shapes[i], bob::affine_map(transforms + 16 * i), material_of(materials + of_material * i)));
        }
        std::ranges::copy(bob::canonical_order(digests), order);
        return true;
    });
}

/// Writes the three singular values of the linear part of a map, (4, 4), the largest first.
EXPORT(singular_values) void singular_values(const double* map, double* values) {
    std::ranges::copy(bob::singular_values(bob::affine_map(map)), values);
}

// ---- Scenes ----------------------------------------------------------------------------------------------

/// Fails if a scene or file has too many instances, called `name`.
EXPORT(check_instances) bool check_instances(const char* name, std::size_t size, double count) {
    return attempt([&] {
        bob::check_instances({name, size}, static_cast<std::size_t>(count));
        return true;
    });
}

/// transforms: (count, 4, 4), from the shapes' units to the scene's; materials: (count, of_material). Writes the centre and
/// radius of the bounding sphere, in the scene's units.
EXPORT(make_scene)
bob::Scene* make_scene(const Shape* const* shapes, std::size_t count, const double* transforms, const double* materials, bob::Sphere* sphere) {
    return attempt([&] {
        std::vector<bob::Placed> placed;
        for (std::size_t i = 0; i < count; ++i) {
            placed.push_back({shapes[i]->core, bob::affine_map(transforms + 16 * i), material_of(materials + of_material * i)});
        }
        const bob::Arrangement arrangement(std::move(placed));
        *sphere = arrangement.sphere();
        return new bob::Scene(arrangement.scene());
    });
}
/// Whether its pictures have colours: `is_colored` below and in wasm_completion.cpp.
EXPORT(scene_is_colored) bool scene_is_colored(const bob::Scene* scene) { return scene->is_colored(); }
EXPORT(free_scene) void free_scene(bob::Scene* scene) { delete scene; }

/// Traces pixels, (count, 2). camera: as for camera_of; samples: (count, C) of the traced layout.
EXPORT(trace)
bool trace(const bob::Scene* scene, const float* camera, std::int32_t height, std::int32_t width,
           const std::int32_t* pixels, std::size_t count, bool is_colored, float* samples) {
    return attempt([&] {
        const std::span all(reinterpret_cast<const bob::Pixel*>(pixels), count);
        bob::trace(*scene, camera_of(camera), height, width, all, traced_layout(is_colored), samples);
        return true;
    });
}

/// Traces rows into planes of the traced layout, (C, rows, width), whose first row is the picture's row `top`; as trace_rows.
EXPORT(trace_rows)
bool trace_rows(const bob::Scene* scene, const float* camera, std::int32_t height, std::int32_t width, std::int32_t begin, std::int32_t end,
                bool is_colored, float* planes, std::int32_t top, std::int32_t rows) {
    return attempt([&] {
        bob::trace_rows(*scene, camera_of(camera), height, width, begin, end, traced_layout(is_colored), planes, top, rows);
        return true;
    });
}

/// The pixels at edges, (n, 2), of some rows of such planes, all counted from their first row, valid until the next call; writes n to `count`.
EXPORT(pixels_at_edges)
const bob::Pixel* pixels_at_edges(bool is_colored, const float* planes, std::int32_t rows, std::int32_t width, std::int32_t begin,
                                  std::int32_t end, std::uint32_t* count) {
    return attempt([&] {
        static std::vector<bob::Pixel> found;
        const bob::Layout& layout = traced_layout(is_colored);
        const std::size_t size = static_cast<std::size_t>(rows) * static_cast<std::size_t>(width);
        const auto plane = [&](const bob::Channel& channel) { return planes + static_cast<std::size_t>(layout.place_of(channel)) * size; };
        const float* const first = plane(is_colored ? bob::channels::color : bob::channels::gray);
        const std::array light{bob::LightPlane{first}, bob::LightPlane{first + size}, bob::LightPlane{first + 2 * size}};
        found = bob::pixels_at_edges(std::span(light).first(is_colored ? 3 : 1), plane(bob::channels::depth), rows, width, begin, end);
        *count = static_cast<std::uint32_t>(found.size());
        return found.data() ? found.data() : reinterpret_cast<const bob::Pixel*>(planes);  // 0 would be a failure
    });
}

/// Writes the means over side x side rays in each pixel, (count, 5), as trace_means.
EXPORT(trace_means)
bool trace_means(const bob::Scene* scene, const float* camera, std::int32_t height, std::int32_t width, const bob::Pixel* pixels,
                 std::size_t count, std::int32_t side, float* means) {
    return attempt([&] {
        bob::trace_means(*scene, camera_of(camera), height, width, {pixels, count}, side, means);
        return true;
    });
}

// ---- Pixel orders ----------------------------------------------------------------------------------------

EXPORT(make_adaptive_order)
bob::RoundOrder* make_adaptive_order(std::uint32_t seed_low, std::uint32_t seed_high, std::uint32_t height, std::uint32_t width) {
    return attempt([&] { return new bob::AdaptiveOrder(joined(seed_low, seed_high), height, width); });
}
EXPORT(make_squares_order) bob::RoundOrder* make_squares_order(std::uint32_t height, std::uint32_t width) {
    return attempt([&] { return new bob::SquaresOrder(height, width); });
}
EXPORT(make_whole_order) bob::RoundOrder* make_whole_order(std::uint32_t height, std::uint32_t width) {
    return attempt([&] { return new bob::WholeOrder(height, width); });
}
EXPORT(free_round_order) void free_round_order(bob::RoundOrder* order) { delete order; }

/// The next round's pixels, (n, 2), valid until the next call; writes n to `count`. planes: (C, height, width) of the
/// traced layout; only pixels of earlier rounds are read. Fails if all pixels were chosen.
EXPORT(next_round)
const bob::Pixel* next_round(bob::RoundOrder* order, bool is_colored, const float* planes, std::uint32_t* count) {
    return attempt([&] {
        const std::span<const bob::Pixel> round = order->next(traced_layout(is_colored), planes);
        expect(!round.empty(), "order: expected pixels that are left, got none");
        *count = static_cast<std::uint32_t>(round.size());
        return round.data();
    });
}

// ---- Cameras that move -----------------------------------------------------------------------------------

EXPORT(make_history) bob::History* make_history(bool is_colored, std::uint32_t height, std::uint32_t width) {
    return attempt([&] { return new bob::History(traced_layout(is_colored), height, width); });
}
EXPORT(free_history) void free_history(bob::History* history) { delete history; }

/// Adds the traced pixels of a camera, planes of the traced layout.
EXPORT(add_to_history) bool add_to_history(bob::History* history, const float* camera, const float* planes) {
    return attempt([&] {
        history->add(camera_of(camera), planes);
        return true;
    });
}

/// Reprojects the history to a camera, shades it, and writes planes of the traced layout. Also writes the distances of
/// samples from the pixels' centres, (height, width), and to `surfaces` the number of pixels with a surface.
EXPORT(expect_from_history)
bool expect_from_history(bob::History* history, const bob::Scene* scene, const float* camera, float* planes, float* off_center,
                         std::uint32_t* surfaces) {
    return attempt([&] {
        const bob::Shading shading(*scene, camera_of(camera), static_cast<int>(history->height()), static_cast<int>(history->width()),
                                   history->layout(), planes);
        *surfaces = static_cast<std::uint32_t>(history->expect(camera_of(camera), planes, off_center, shading));
        return true;
    });
}

EXPORT(make_refresh_order) bob::RefreshOrder* make_refresh_order(std::uint32_t height, std::uint32_t width) {
    return attempt([&] { return new bob::RefreshOrder(height, width); });
}
EXPORT(free_refresh_order) void free_refresh_order(bob::RefreshOrder* order) { delete order; }
EXPORT(begin_refresh) void begin_refresh(bob::RefreshOrder* order, std::uint32_t seed_low, std::uint32_t seed_high) {
    order->begin(joined(seed_low, seed_high));
}

/// As next_round, for a picture with reprojected samples; traced, picture: planes of the traced layout.
EXPORT(next_refresh)
const bob::Pixel* next_refresh(bob::RefreshOrder* order, bool is_colored, const float* traced, const float* picture,
                               const float* off_center, std::uint32_t wanted, std::uint32_t* count) {
    return attempt([&] {
        const std::span<const bob::Pixel> round = order->next(traced_layout(is_colored), traced, picture, off_center, wanted);
        expect(!round.empty(), "order: expected pixels that are left, got none");
        *count = static_cast<std::uint32_t>(round.size());
        return round.data();
    });
}

// ---- Frames ----------------------------------------------------------------------------------------------

/// completes_meanwhile: as in FramePlanner. All networks are available; modes and completions are numbered as in its
/// enums.
EXPORT(make_planner) bob::FramePlanner* make_planner(bool completes_meanwhile) {
    constexpr std::array all = {bob::Completion::filling, bob::Completion::small, bob::Completion::standard};
    return new bob::FramePlanner(1, all, completes_meanwhile);
}
EXPORT(free_planner) void free_planner(bob::FramePlanner* planner) { delete planner; }
EXPORT(planner_traced)
void planner_traced(bob::FramePlanner* planner, bob::Mode mode, double pixels, double seconds, bool is_first_round) {
    planner->traced(mode, pixels, seconds, is_first_round);
}
EXPORT(planner_completed)
void planner_completed(bob::FramePlanner* planner, bob::Completion completion, double pixels, double seconds) {
    planner->completed(completion, pixels, seconds);
}
EXPORT(planner_reprojected) void planner_reprojected(bob::FramePlanner* planner, double pixels, double seconds) {
    planner->reprojected(pixels, seconds);
}
double parallax_between(const float* before, const float* camera, std::int32_t height, std::int32_t width) {
    return before ? bob::parallax(camera_of(before), camera_of(camera), height, width) : std::numeric_limits<double>::infinity();
}
/// The divisor of a moving picture's height and width. before: the camera of the last picture, whose divisor was `last`, or null if
/// nothing can be reprojected.
EXPORT(frame_scale)
double frame_scale(bob::FramePlanner* planner, const float* before, const float* camera, std::int32_t height, std::int32_t width,
                   double seconds, double threads, double last) {
    return planner->scale(static_cast<double>(height) * width, last, seconds, parallax_between(before, camera, height, width), threads);
}
/// Sets the size of the pictures; `before` as in frame_scale.
EXPORT(plan_frame)
bob::Mode plan_frame(bob::FramePlanner* planner, const float* before, const float* camera, std::int32_t height, std::int32_t width,
                     double seconds, double threads) {
    planner->resize(static_cast<std::size_t>(height) * static_cast<std::size_t>(width));
    return planner->plan(seconds, parallax_between(before, camera, height, width), threads);
}
EXPORT(frame_completion)
bob::Completion frame_completion(const bob::FramePlanner* planner, bob::Mode mode, double known, double seconds, double threads) {
    return planner->completion(mode, known, seconds, threads);
}
EXPORT(frame_tracing) double frame_tracing(const bob::FramePlanner* planner, bob::Mode mode, bob::Completion completion, double seconds) {
    return planner->for_tracing(mode, completion, seconds);
}
/// The number of pixels in a call of `seconds`.
EXPORT(frame_pixels) double frame_pixels(const bob::FramePlanner* planner, bob::Mode mode, double seconds) {
    return planner->pace(mode).pixels_in(seconds);
}
