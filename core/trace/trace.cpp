#include "trace/trace.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "parallel.h"
#include "trace/shading.h"

namespace bob {
namespace {

// Rays start outside the unit sphere by this much, so that surfaces on it are in front of them.
constexpr float start_margin = 1e-3f;

Sample shade(const Mesh& mesh, const Frame& frame, const Ray& ray, const Hit& hit) {
    const Vec3 n = mesh.shading_normal(hit, ray.direction);
    Vec3 normal{dot(n, frame.right), dot(n, frame.up), dot(n, frame.toward)};
    // Near silhouettes smooth normals lean away from the camera a little: as far as the eye can tell, edge-on.
    if (normal.z < 0) normal.z = 0;
    normal = normalized(normal);
    if (dot(normal, normal) == 0) normal = {0, 0, 1};
    const Vec3 point = ray.origin + hit.t * ray.direction;
    const float depth = std::clamp(0.5f + 0.5f * dot(point, frame.toward), 0.f, 1.f);
    return {blinn_phong(normal), depth, {normal.x, normal.y}, true};
}

}  // namespace

bool trace(const Mesh& mesh, const Camera& camera, int height, int width, std::span<const Pixel> pixels,
           const Samples& samples, const std::function<bool()>& keep_going) {
    const Frame frame(camera);
    const Raster raster(height, width, camera.zoom);
    constexpr std::size_t grain = 512;
    return parallel_for(pixels.size(), grain, [&](std::size_t begin, std::size_t end) {
        std::array<Ray, grain> rays;
        std::array<Hit, grain> hits;
        std::array<std::size_t, grain> sample;
        std::size_t count = 0;
        for (std::size_t i = begin; i < end; ++i) {
            const float x = raster.x(pixels[i].column), y = raster.y(pixels[i].row);
            const float z2 = 1 - x * x - y * y;
            if (z2 < -start_margin) {
                samples.set(i, {});
                continue;
            }
            const float z = std::sqrt(std::max(0.f, z2)) + start_margin;
            rays[count] = {x * frame.right + y * frame.up + z * frame.toward, -frame.toward};
            sample[count++] = i;
        }
        mesh.closest_hits({rays.data(), count}, {hits.data(), count});
        for (std::size_t i = 0; i < count; ++i) {
            const bool hit = hits[i].triangle != no_triangle;
            samples.set(sample[i], hit ? shade(mesh, frame, rays[i], hits[i]) : Sample{});
        }
    }, keep_going);
}

}  // namespace bob
