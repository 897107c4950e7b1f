/// Scenes: shapes placed by maps that readers let pass, seen by any camera. Samples are in range, and each equals its
/// pixel traced alone.
#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <optional>
#include <stdexcept>
#include <vector>

#include "fuzz/fuzz.h"
#include "shapes/brep/brep.h"
#include "shapes/mesh/mesh.h"
#include "shapes/tube/tube.h"
#include "tracing/arrangement.h"
#include "tracing/trace.h"

namespace {

using Shape = std::shared_ptr<const bob::Shape>;

Shape tetrahedron() {
    static const std::array<bob::Mesh::Point, 4> vertices{{{0, 0, 1}, {1, 0, -1}, {-1, 1, -1}, {-1, -1, -1}}};
    static const std::array<bob::Triangle, 4> triangles{{{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}}};
    return std::make_shared<bob::Mesh>(bob::Mesh::Arrays{vertices, triangles, {}, nullptr});
}

Shape patch() {
    bob::Face face{{1, 1, {0, 0, 1, 1}, {0, 0, 1, 1}, {{-1, -1, 0, 1}, {-1, 1, 1, 1}, {1, -1, 1, 2}, {1, 1, 0, 1}}}, {}};
    return std::make_shared<bob::Brep>(bob::Brep::of_weighted_points({face}, 0));
}

Shape rod() {
    return std::make_shared<bob::Tube>(bob::Tube::of_weighted_points({1, {0, 0, 1, 1}, {{-1, 0, 0, 0.25, 1}, {1, 0, 0.5, 0.5, 1}}}));
}

/// One of each kind but formulas, which take long to measure.
const Shape& shape(std::uint32_t which) {
    static const std::array shapes{tetrahedron(), patch(), rod()};
    return shapes[which % shapes.size()];
}

/// Nothing where readers would refuse it.
std::optional<bob::AffineMap> transform(fuzz::Source& source) {
    double matrix[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    const std::uint8_t kind = source.byte();
    for (int i = 0; i < 12; ++i) {
        if (kind < 64 ? i % 4 == 3 : kind < 128 ? i % 5 == 0 || i % 4 == 3 : kind < 250) matrix[i] = source.number();
    }
    for (const double value : matrix) {
        if (!std::isfinite(value)) return std::nullopt;
    }
    const bob::AffineMap map = bob::affine_map(matrix);
    const auto sizes = bob::singular_values(map);
    if (!(sizes[2] > 1e-10 * sizes[0])) return std::nullopt;
    return map;
}

}  // namespace

FUZZ(scene) {
    std::vector<bob::Placed> placed;
    for (int count = source.between(1, 6); count > 0; --count) {
        const auto map = transform(source);
        if (!map) return;
        const auto unit = [&] { return source.byte() / 255.; };
        const bob::Material material{{unit(), unit(), unit()}, unit(), unit(), unit(), 10000 * unit() * unit()};
        placed.push_back({shape(source.byte()), *map, material});
    }
    std::vector<bob::Digest> digests(source.flag() ? placed.size() : 0);
    for (std::size_t i = 0; i < digests.size(); ++i) digests[i] = bob::instance_digest({}, placed[i].transform, placed[i].material);
    std::optional<bob::Scene> scene;
    try {
        scene.emplace(bob::Arrangement(std::move(placed)).scene(digests));
    } catch (const std::invalid_argument&) {  // out of range
        return;
    }
    bob::Camera camera;
    camera.azimuth_degrees = static_cast<float>(source.within(-360, 360));
    camera.elevation_degrees = static_cast<float>(source.within(-90, 90));
    camera.zoom = static_cast<float>(std::pow(10, source.within(-1, 4)));
    if (source.flag()) camera.pan_x = static_cast<float>(source.within(-1, 1)), camera.pan_y = static_cast<float>(source.within(-1, 1));
    if (source.flag()) {
        camera.fov_degrees = static_cast<float>(source.within(1, 150));
        if (source.flag()) {
            const double x = source.within(-2, 2), y = source.within(-2, 2), z = source.within(-2, 2);
            camera.standpoint = {{x, y, z}, {x + 1, y + source.within(-1, 1), z + source.within(-1, 1)}, {0, 0, 1}};
        }
    }
    constexpr int side = 6;
    std::vector<bob::Pixel> pixels;
    for (int i = 0; i < side * side; ++i) pixels.push_back({i / side, i % side});
    const bob::Layout& layout = bob::gbuffer_layout();
    std::vector<float> samples(pixels.size() * 5), alone(5);
    bob::trace(*scene, camera, side, side, pixels, layout, samples.data());
    for (std::size_t i = 0; i < pixels.size(); ++i) {
        const float* const s = &samples[5 * i];
        fuzz::expect((s[0] == 0 || s[0] == 1) && s[1] >= 0 && s[1] <= 1 && s[2] >= 0 && s[2] <= 1, "samples in range");
        fuzz::expect(s[3] * s[3] + s[4] * s[4] < 1.001f, "a normal of length 1");
        bob::trace(*scene, camera, side, side, {&pixels[i], 1}, layout, alone.data());
        fuzz::expect(std::memcmp(s, alone.data(), 5 * sizeof(float)) == 0, "a sample that depends on its pixel alone");
    }
}
