#include "tracing/trace.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "parallel.h"
#include "tracing/shading.h"

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

    /// Each thread keeps one from call to call.
    static Batch& of_this_thread(std::size_t most_rays) {
        thread_local Batch batch;
        if (batch.rays.size() < most_rays) {
            batch.sample.resize(most_rays), batch.rays.resize(most_rays);
            batch.hits.resize(most_rays), batch.normals.resize(most_rays);
        }
        return batch;
    }
};

}  // namespace

bool trace(const Scene& scene, const Camera& camera, int height, int width, std::span<const Pixel> pixels,
           const Samples& samples, const std::function<bool()>& keep_going) {
    const Frame frame(camera);
    const Raster raster(height, width, camera);
    return parallel_for(pixels.size(), batch_size(pixels.size()), [&](std::size_t begin, std::size_t end) {
        Batch& batch = Batch::of_this_thread(end - begin);
        std::size_t count = 0;
        for (std::size_t i = begin; i < end; ++i) {
            const float x = raster.x(pixels[i].column), y = raster.y(pixels[i].row);
            const float z2 = 1 - x * x - y * y;
            if (z2 < -start_margin) {
                samples.set(i, {});
                continue;
            }
            const float z = std::sqrt(std::max(0.f, z2)) + start_margin;
            batch.rays[count] = {x * frame.right + y * frame.up + z * frame.toward, -frame.toward};
            batch.sample[count++] = i;
        }
        const std::span<const Ray> rays{batch.rays.data(), count};
        scene.closest_hits(rays, {batch.hits.data(), count});
        scene.normals(rays, {batch.hits.data(), count}, {batch.normals.data(), count});
        for (std::size_t j = 0; j < count; ++j) {
            const SceneHit& hit = batch.hits[j];
            Sample sample;
            if (hit.instance != no_instance) {
                const Vec3 point = rays[j].origin + hit.t * rays[j].direction;
                sample = shade(scene[hit.instance].material, frame, point, batch.normals[j]);
            }
            samples.set(batch.sample[j], sample);
        }
    }, keep_going);
}

}  // namespace bob
