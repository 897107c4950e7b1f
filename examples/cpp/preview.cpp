// Completes the picture of a slow tracer: preview.pgm, from 5 % of the pixels or from the share that is given.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <vector>

#include "completion/interpolation.h"
#include "completion/known.h"
#include "completion/network.h"
#include "picture/gbuffer.h"
#include "sampling/adaptive.h"

constexpr int height = 480, width = 640;

struct Point {
    double x, y, z;
    Point towards(Point d, double t) const { return {x + t * d.x, y + t * d.y, z + t * d.z}; }
};

/// The distance to a knot of two rings above a floor.
double distance(Point p) {
    const auto ring = [](double along, double across, double up) {
        return std::hypot(std::hypot(along, up) - 1, across) - 0.25;
    };
    return std::min({p.z + 1.3, ring(p.x + 0.5, p.y, p.z), ring(p.x - 0.5, p.z, p.y)});
}

/// The length of a ray to the first surface, or `end`.
double march(Point origin, Point direction, double end) {
    double t = 0.01;
    for (double step = 1; t < end && step > 1e-4; t += step) step = distance(origin.towards(direction, t));
    return std::min(t, end);
}

/// The slow part: gray in 0..1, the share of a large lamp that the surface at a pixel sees.
float shade(bob::Pixel pixel) {
    const Point eye{0, -6, 1.5}, direction{(pixel.column - 0.5 * width) / height, 1, (0.3 * height - pixel.row) / height};
    const double depth = march(eye, direction, 20);
    if (depth == 20) return 0.2f;
    const Point surface = eye.towards(direction, depth - 0.01);
    double light = 0;
    for (int i = 0; i < 64; ++i) {
        const double x = -3 + 0.4 * (i % 8), y = -3 + 0.4 * (i / 8), z = 4;  // a point of the lamp
        light += march(surface, {x - surface.x, y - surface.y, z - surface.z}, 1) == 1;
    }
    return static_cast<float>(0.9 * std::sqrt(light / 64));
}

int main(int count, char** arguments) {
    const double share = count > 1 ? std::atof(arguments[1]) : 0.05;
    const bob::Layout known{bob::channels::mask, bob::channels::gray}, completed{bob::channels::gray};
    const std::size_t pixels = std::size_t{height} * width;
    std::vector<float> planes(2 * pixels);  // the mask, then gray

    bob::AdaptiveOrder order(0, height, width);
    std::size_t traced = 0;
    for (auto round = order.next(known, planes.data()); !round.empty(); round = order.next(known, planes.data())) {
        std::vector<float> samples;
        for (const bob::Pixel pixel : round) samples.insert(samples.end(), {1, shade(pixel)});  // a hit, and its gray
        traced += bob::scatter(known, round, samples.data(), 2, planes.data(), height, width);
        if (static_cast<double>(traced) >= share * static_cast<double>(pixels)) break;
    }

    const auto network = bob::make_network("filling", {known, completed, {}});
    std::vector<float> gray(pixels);
    (*network)(planes.data(), height, width, gray.data());
    bob::interpolate_lattice(known, planes.data(), completed, gray.data(), height, width);
    bob::keep_known(known, planes.data(), completed, gray.data(), pixels);

    std::ofstream picture("preview.pgm", std::ios::binary);
    picture << "P5 " << width << ' ' << height << " 255\n";
    for (const float value : gray) picture.put(static_cast<char>(static_cast<std::uint8_t>(value * 255 + 0.5f)));
}
