#include "trace/trace.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "parallel.h"
#include "trace/shading.h"

namespace bob {
namespace {

// Rays start outside the unit sphere by this much, so that surfaces on it are in front of them.
constexpr float start_margin = 1e-3f;

Sample shade(const Material& material, const Frame& frame, Vec3 point, Vec3 n) {
    Vec3 normal{dot(n, frame.right), dot(n, frame.up), dot(n, frame.toward)};
    // Near silhouettes smooth normals lean away from the camera a little: as far as the eye can tell, edge-on.
    if (normal.z < 0) normal.z = 0;
    normal = normalized(normal);
    if (dot(normal, normal) == 0) normal = {0, 0, 1};
    const float depth = std::clamp(0.5f + 0.5f * dot(point, frame.toward), 0.f, 1.f);
    return {blinn_phong(normal, material), depth, {normal.x, normal.y}, true};
}

/// Rays that start at the unit sphere, and the samples that they are for.
struct Batch {
    std::vector<std::size_t> sample;
    std::vector<Ray> rays;
    std::vector<SceneHit> hits;
    std::vector<Vec3> normals;

    void clear() { sample.clear(), rays.clear(); }
    void resize_results() { hits.resize(rays.size()), normals.resize(rays.size()); }
};

}  // namespace

bool trace(const Scene& scene, const Camera& camera, int height, int width, std::span<const Pixel> pixels,
           const Samples& samples, const std::function<bool()>& keep_going) {
    const Frame frame(camera);
    const Raster raster(height, width, camera.zoom);
    return parallel_for(pixels.size(), batch_size(pixels.size()), [&](std::size_t begin, std::size_t end) {
        thread_local Batch batch;
        batch.clear();
        for (std::size_t i = begin; i < end; ++i) {
            const float x = raster.x(pixels[i].column), y = raster.y(pixels[i].row);
            const float z2 = 1 - x * x - y * y;
            if (z2 < -start_margin) {
                samples.set(i, {});
                continue;
            }
            const float z = std::sqrt(std::max(0.f, z2)) + start_margin;
            batch.rays.push_back({x * frame.right + y * frame.up + z * frame.toward, -frame.toward});
            batch.sample.push_back(i);
        }
        batch.resize_results();
        scene.closest_hits(batch.rays, batch.hits);
        scene.normals(batch.rays, batch.hits, batch.normals);
        for (std::size_t j = 0; j < batch.rays.size(); ++j) {
            const SceneHit& hit = batch.hits[j];
            Sample sample;
            if (hit.instance != no_instance) {
                const Vec3 point = batch.rays[j].origin + hit.t * batch.rays[j].direction;
                sample = shade(scene[hit.instance].material, frame, point, batch.normals[j]);
            }
            samples.set(batch.sample[j], sample);
        }
    }, keep_going);
}

}  // namespace bob
