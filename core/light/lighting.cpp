#include "light/lighting.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include "base/color.h"
#include "base/parallel.h"
#include "base/thread_memory.h"
#include "light/dielectric.h"
#include "light/directions.h"
#include "light/edges.h"
#include "light/reflection.h"
#include "light/sobol.h"

namespace bob {
namespace {

/// Paths that are traced together: enough for shapes that sort their rays, few enough for a thread's cache.
constexpr std::size_t paths_at_once = 4096;

/// Surfaces that a path meets at most, mirrors counted.
constexpr int max_surfaces = 8;

/// The same of paths through glass, which end sooner where less than this share of their light is left.
constexpr int max_in_glass = 32;
constexpr float min_throughput = 1e-3f;

/// Limits of the squared roughness: smoother mirrors and glass show images.
constexpr float smooth = 0.02f, smoothest = 1e-3f;

float squared_roughness(const Material& material) {
    const float roughness = Material::rounded(material.roughness);
    return std::max(smoothest, roughness * roughness);
}
bool shows_things(const Material& material) {
    return material.is_physical() && squared_roughness(material) <= smooth && (material.transmission >= 0.5 || material.metallic >= 0.5);
}

/// Smooth sheets of glass send light straight on: rays to lights pass them.
bool is_smooth_sheet(const Material& material) { return material.transmission > 0 && material.is_thin && squared_roughness(material) <= smooth; }

/// Glass in larger scenes is as clear as in scenes of this radius, in their units.
constexpr double max_radius = 1e38;

/// More than what rounding moves a point of the unit sphere by, from the numbers of its ray on.
constexpr float rounding = 0x1p-21f;

/// The variance is estimated from the means of this many runs of a pixel's samples.
constexpr std::uint32_t max_runs = 4;

/// Groups of the sequence for each surface of a path: one for its direction, and one for each light.
constexpr std::uint32_t groups_of_surface = 64;

Vec3 product(Vec3 a, Vec3 b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }

/// The ground reflects half of the light to other surfaces. To the eye it only shows shadows.
const Material& ground_material() {
    static const Material material = [] {
        Material gray;
        for (double& c : gray.color) c = 0.5;
        gray.ambient = 0, gray.diffuse = 1, gray.specular = 0;
        return gray;
    }();
    return material;
}

/// The t where a ray enters a sphere somewhat larger than the scene's, at least 0; negative if the ray misses it.
float entry(const Ray& ray) {
    constexpr double squared_radius = 1.02;
    double along = 0, squared = 0, from_centre = 0;
    for (int k = 0; k < 3; ++k) {
        along -= static_cast<double>(ray.origin[k]) * static_cast<double>(ray.direction[k]);
        squared += static_cast<double>(ray.direction[k]) * static_cast<double>(ray.direction[k]);
        from_centre += static_cast<double>(ray.origin[k]) * static_cast<double>(ray.origin[k]);
    }
    if (from_centre <= squared_radius) return 0;
    const double inside = along * along - squared * (from_centre - squared_radius);
    if (along <= 0 || inside < 0) return -1;
    return static_cast<float>((along - std::sqrt(inside)) / squared);
}

/// The balance heuristic: the first density's share of two ways to draw the same direction.
float share_of(float own, float other) { return std::isinf(own) ? 1 : own / (own + other); }

}  // namespace

/// The end of a ray.
struct Lighting::Met {
    enum Kind : std::uint8_t { sky, ground, surface };

    Kind kind = sky;
    std::uint32_t instance = no_instance;
    float start = 0;               // how far above the surface rays start
    Vec3 point, normal, face;      // the normals turned to the ray
    Vec3 color;                    // of the shape and its material together
    const Material* material = nullptr;
};

/// A place in a picture; pixel centres are at whole numbers.
struct Lighting::Place {
    float row, column;
};

struct Lighting::Memory {
    std::vector<Ray> inner;
    std::vector<std::uint32_t> number;  // of the ray that each inner one is of
    std::vector<float> entered, inner_widths;
    std::vector<SceneHit> hits;
    std::vector<Vec3> normals, faces, colors;
    std::vector<Met> met;
};

void Lighting::meet(std::span<const Ray> rays, std::span<const float> widths, std::span<const std::uint8_t> wants, Memory& memory) const {
    auto& [inner, number, entered, inner_widths, hits, normals, faces, colors, met] = memory;
    inner.clear(), number.clear(), entered.clear();
    met.assign(rays.size(), {});
    for (std::uint32_t i = 0; i < rays.size(); ++i) {
        const float start = entry(rays[i]);
        if (start >= 0) inner.push_back({rays[i].origin + start * rays[i].direction, rays[i].direction}), number.push_back(i), entered.push_back(start);
    }
    hits.resize(inner.size());
    scene_.closest_hits(inner, hits);
    for (std::size_t j = 0; j < inner.size(); ++j) {
        if (hits[j].instance == no_instance) continue;
        Met& m = met[number[j]];
        m.kind = Met::surface, m.instance = hits[j].instance, m.material = &scene_[m.instance].material;
    }
    if (has_ground()) {
        std::size_t j = 0;
        for (std::uint32_t i = 0; i < rays.size(); ++i) {
            while (j < number.size() && number[j] < i) ++j;
            const bool is_inner = j < number.size() && number[j] == i;
            const auto& [origin, direction] = rays[i];
            if (!(direction.z < 0) || !(origin.z > ground_)) continue;
            const float t = (ground_ - origin.z) / direction.z;
            if (is_inner && !(t < entered[j] + hits[j].t)) continue;
            Vec3 point = origin + t * direction;
            if (!std::isfinite(point.x) || !std::isfinite(point.y)) continue;  // of the horizon
            point.z = ground_;
            met[i] = {Met::ground, no_instance, rounding, point, {0, 0, 1}, {0, 0, 1}, ground_material().base_color(), &ground_material()};
            if (is_inner) hits[j].instance = no_instance;
        }
    }
    std::size_t wanted = 0;
    inner_widths.resize(inner.size());
    for (std::size_t j = 0; j < inner.size(); ++j) {
        if (hits[j].instance == no_instance || !(wants[number[j]] || sheets_[hits[j].instance])) continue;
        inner[wanted] = inner[j], number[wanted] = number[j], hits[wanted] = hits[j], inner_widths[wanted] = widths[number[j]];
        ++wanted;
    }
    normals.resize(wanted), faces.resize(wanted), colors.resize(wanted);
    const std::span<const Ray> some{inner.data(), wanted};
    const std::span<const SceneHit> found{hits.data(), wanted};
    scene_.normals_and_colors(some, found, {inner_widths.data(), wanted}, normals, colors);
    scene_.face_normals(some, found, faces);
    for (std::size_t j = 0; j < wanted; ++j) {
        Met& m = met[number[j]];
        const Ray& ray = inner[j];
        m.start = errors_[m.instance];
        m.point = ray.origin + hits[j].t * ray.direction;
        m.face = faces[j], m.normal = normals[j], m.color = product(m.material->base_color(), colors[j]);
        // A face without an area and a formula without a slope face the ray.
        if (dot(m.face, m.face) == 0) m.face = -normalized(ray.direction);
        if (dot(m.normal, m.normal) == 0) m.normal = m.face;
    }
}

float Lighting::index(const Media& media) const { return media.is_empty() ? 1 : Material::rounded(scene_[media.last()].material.ior); }

Media Lighting::media_around(const Projection& projection) const {
    Media media;
    if (!has_glass_ || !projection.in_perspective()) return media;
    // Outwards from the eye, a solid that is met an odd number of times is around it; the first to be left is the innermost.
    Ray ray{projection.line(0, 0).origin, normalized({0.36f, 0.48f, 0.8f})};
    std::vector<std::uint32_t> met, around;
    for (int k = 0; k < max_in_glass; ++k) {
        SceneHit hit;
        scene_.closest_hits({&ray, 1}, {&hit, 1});
        if (hit.instance == no_instance) break;
        if (scene_[hit.instance].material.transmission > 0 && !scene_[hit.instance].material.is_thin) met.push_back(hit.instance);
        ray.origin = ray.origin + (hit.t + 2 * errors_[hit.instance]) * ray.direction;
    }
    for (const std::uint32_t instance : met) {
        if (std::ranges::count(met, instance) % 2 == 1 && std::ranges::find(around, instance) == around.end()) around.push_back(instance);
    }
    for (auto instance = around.rbegin(); instance != around.rend(); ++instance) media.enter(*instance);
    return media;
}

bool Lighting::sees(const Projection& projection, float row, float column, Ray& ray) const {
    const bool is_inner = projection.ray(row, column, ray);
    if (!has_ground()) return is_inner;
    const Ray line = projection.line(row, column);
    if (is_inner && (ray.origin.z > ground_ || !(line.origin.z > ground_))) return true;
    ray = line;  // which meets the ground before it could enter the scene, or passes the scene by
    return true;
}

Lighting::Lighting(const Scene& scene, Lights lights)
    : scene_(scene), lights_(std::move(lights)), ground_(lights_.has_ground ? scene.lowest() : std::numeric_limits<float>::infinity()),
      radius_(static_cast<float>(std::min(lights_.radius, max_radius))) {
    for (std::uint32_t k = 0; k < scene.size(); ++k) {
        const Instance& instance = scene[k];
        const double min_scale = singular_values(instance.to_shape)[2];
        has_glass_ = has_glass_ || instance.material.transmission > 0, shows_things_ = shows_things_ || shows_things(instance.material);
        sheets_.push_back(is_smooth_sheet(instance.material));
        errors_.push_back(static_cast<float>(std::min(1., static_cast<double>(instance.shape->hit_error()) / min_scale)) + rounding);
    }
    const Sky& sky = lights_.sky;
    double sum = 0, weights = 0;
    constexpr int rows = 256, columns = 512;
    for (int row = 0; row < rows; ++row) {
        const double z = (row + 0.5) / rows, ring = std::sqrt(1 - z * z);
        for (int column = 0; column < columns; ++column) {
            const double angle = 2 * 3.14159265358979323846 * (column + 0.5) / columns;
            const Vec3 toward{static_cast<float>(ring * std::cos(angle)), static_cast<float>(ring * std::sin(angle)), static_cast<float>(z)};
            sum += z * static_cast<double>(luminance(sky.radiance(toward))), weights += z;
            if (!sky.environment) break;  // equal in all azimuths
        }
    }
    ground_light_ = static_cast<float>(sum / weights);
    for (const DiscLight& disc : lights_.discs) ground_light_ += luminance(disc.color) * std::max(0.f, disc.direction.z);
}

namespace {

struct Path {
    Vec3 throughput{1, 1, 1};
    // Of the direction that it was last scattered to, for the balance heuristic; infinite if no light is sampled there.
    float density = std::numeric_limits<float>::infinity();
    std::uint32_t slot = 0;
    std::int32_t left = 0;  // surfaces that it may still be shaded at
    float change = 0;       // of its light for each radian that the eye turns by
    Media media;
    bool through_glass = false;
    bool to_ground = false;    // rather than to the eye: its light reduces the shadow there
    bool from_ground = false;  // not yet scattered; the ground samples discs by itself
};

/// Light on its way, which arrives unless anything but sheets is between.
struct Sent {
    Vec3 light;
    float change;
    float lost;  // of the ground: the share of its light that is missing if nothing arrives
    std::uint32_t slot;
    enum To : std::uint8_t { surface, surface_beside_ground, ground } to;
};

/// The sum of one path.
struct Arrived {
    Vec3 color, albedo, normal;
    float shadow = 0, depth = 0, change = 0;
    bool is_hit = false, is_uncertain = false;
};

}  // namespace

/// Paths of one thread, on their way together.
class Lighting::Paths {
public:
    /// Rays see textures as wide as their share of a pixel.
    Paths(const Lighting& lighting, const Projection& projection, float share, bool asks_for_changes)
        : lighting_(lighting), lights_(lighting.lights_), projection_(projection), width_(share * projection.pixel_width(0.5f)),
          asks_for_changes_(asks_for_changes), media_(lighting.media_around(projection)) {}

    std::vector<Arrived> arrived;

    void begin(std::size_t count) {
        arrived.assign(count, {}), sequences_.clear(), places_.clear();
        rays_.clear(), paths_.clear(), widths_.clear(), wants_.clear(), first_rays_.clear();
    }

    /// Starts paths at a place in the picture, in the next slots: one for each sequence.
    void add(float row, float column, std::span<const PixelSequence> sequences) {
        auto slot = static_cast<std::uint32_t>(sequences_.size());
        for (const PixelSequence& sequence : sequences) sequences_.push_back(sequence), places_.push_back({row, column});
        Ray ray;
        if (!lighting_.sees(projection_, row, column, ray)) return;
        rays_.push_back(ray), widths_.push_back(width_ / length(ray.direction)), wants_.push_back(1);
        Path path;
        path.left = lights_.bounces, path.media = media_;
        for (; slot < sequences_.size(); ++slot) path.slot = slot, paths_.push_back(path), first_rays_.push_back(rays_.size() - 1);
    }

    void go() {
        for (int surface = 0; !paths_.empty() && surface < max_in_glass + 1; ++surface) {
            lighting_.meet(rays_, widths_, wants_, memory_);
            if (surface == 0) share_first_hits();
            send(surface);
            receive(surface);
        }
    }

private:
    static constexpr float wide = 0.05f;  // of rays that rough surfaces reflect

    struct InPicture {
        float row, column;
    };

    /// Gives each path the ray and the hit that it starts with.
    void share_first_hits() {
        std::vector<Met> met;
        next_rays_.clear();
        for (const std::size_t ray : first_rays_) met.push_back(memory_.met[ray]), next_rays_.push_back(rays_[ray]);
        memory_.met.swap(met), rays_.swap(next_rays_);
    }

    /// Adds the light of paths that left, and sends the others on.
    void send(int surface) {
        next_rays_.clear(), next_paths_.clear(), next_widths_.clear(), next_wants_.clear();
        light_rays_.clear(), sent_.clear();
        const std::vector<Met>& met = memory_.met;
        for (std::size_t i = 0; i < paths_.size(); ++i) {
            Path& path = paths_[i];
            if (!path.media.is_empty() && met[i].kind != Met::sky) {
                const Material& glass = lighting_.scene_[path.media.last()].material;
                path.throughput = product(path.throughput, attenuation(glass, length(met[i].point - rays_[i].origin), lighting_.radius_));
            }
            Arrived& to = arrived[path.slot];
            if (surface == 0) {
                if (met[i].kind == Met::surface) note(to, met[i], path.slot);
                if (met[i].kind == Met::ground) shade_ground(path, met[i]);
                if (met[i].kind != Met::surface) continue;
            } else if (met[i].kind == Met::sky) {
                // A path from the ground counts light of the sky only after it met a surface.
                if (!path.from_ground) {
                    arrive(path, escaped(rays_[i].direction, path.density));
                } else if (surface > 1) {
                    arrive(path, lights_.sky.radiance(rays_[i].direction));
                }
                continue;
            }
            if (path.to_ground && surface == 1) to.shadow += luminance(lights_.sky.radiance(rays_[i].direction)) / lighting_.ground_light_;
            if (met[i].material->emits()) arrive(path, Material::rounded(met[i].material->emissive));
            const bool is_of_sheet = is_sheet(met[i]);
            if (surface >= (path.through_glass || is_of_sheet ? max_in_glass : max_surfaces)) continue;
            if (path.left > 0) {
                shade(path, met[i], rays_[i].direction, surface);
            } else if (is_of_sheet) {
                // It meets no more surfaces, but a light may be behind the sheet.
                const Ray ray = through(met[i], rays_[i].direction, path.throughput);
                if (luminance(path.throughput) >= min_throughput) go_on(ray, path, wide);
            }
        }
        rays_.swap(next_rays_), paths_.swap(next_paths_), widths_.swap(next_widths_), wants_.swap(next_wants_);
    }

    /// Continues a path. One that may not be shaded any more only learns whether there is a surface.
    void go_on(const Ray& ray, const Path& path, float width) {
        next_rays_.push_back(ray), next_paths_.push_back(path), next_widths_.push_back(width), next_wants_.push_back(path.left > 0);
    }

    [[nodiscard]] bool is_sheet(const Met& met) const { return met.kind == Met::surface && lighting_.sheets_[met.instance]; }

    /// Adds light at the end of a path.
    void arrive(const Path& path, Vec3 light) { arrive(path.slot, product(path.throughput, light), path.change, path.to_ground); }
    void arrive(std::uint32_t slot, Vec3 light, float change, bool to_ground) {
        Arrived& to = arrived[slot];
        if (to_ground) {
            to.shadow -= luminance(light) / lighting_.ground_light_;
        } else {
            to.color = to.color + light;
            if (change > 0) to.change += change * luminance(light);
        }
    }

    void note(Arrived& to, const Met& met, std::uint32_t slot) const {
        const auto [row, column] = places_[slot];
        to.is_hit = true, to.albedo = met.color, to.depth = projection_.depth(met.point);
        to.normal = projection_.on_screen(met.normal, row, column);
    }

    /// Light that a direction shows, where no surface is; of lights that are also drawn by themselves, this way's share.
    [[nodiscard]] Vec3 escaped(Vec3 toward, float density) const {
        const Sky& sky = lights_.sky;
        Vec3 light = sky.radiance(toward);
        if (sky.environment) light = share_of(density, sky.environment->density(sky.in_environment(toward))) * light;
        for (const DiscLight& disc : lights_.discs) {
            if (disc.height > 0 && disc.covers(toward)) light = light + share_of(density, density_of(disc)) * disc.radiance();
        }
        return light;
    }
    static float density_of(const DiscLight& disc) { return 1 / (2 * pi * disc.height); }

    /// Sends light from all lights to a surface, and its path on.
    void shade(const Path& path, const Met& met, Vec3 direction, int surface) {
        Arrived& to = arrived[path.slot];
        const Across across(met.normal);
        Vec3 eye = across.to(-normalized(direction));
        eye.z = std::max(eye.z, 1e-3f), eye = normalized(eye);
        const PixelSequence& sequence = sequences_[path.slot];
        const std::uint32_t group = 1 + static_cast<std::uint32_t>(surface) * groups_of_surface;
        // Bodies are seen from outside alone.
        const float transmission = path.media.contains(met.instance) ? 1 : Material::rounded(met.material->transmission);
        if (met.material->transmission > 0 && sequence(group)[3] < transmission) {
            pass(path, met, across, eye, normalized(direction), surface, sequence(group));
            return;
        }
        const Reflection reflection(*met.material, met.color, eye);
        const Vec3 origin = met.point + met.start * met.face;

        const auto send_light = [&](Vec3 toward, Vec3 radiance_over_density, float density, bool is_point) {
            const Vec3 own = across.to(toward);
            if (!(own.z > 0) || !(dot(toward, met.face) > 0)) return;
            const float share = is_point ? 1 : share_of(density, reflection.density(own));
            const Vec3 light = share * product(path.throughput, product(reflection(own), radiance_over_density));
            if (!(luminance(light) > 0)) return;
            const float change = surface == 0 && asks_for_changes_ ? reflection.change_per_radian(own) : path.change;
            light_rays_.push_back({origin, toward}), sent_.push_back({light, change, 0, path.slot, path.to_ground ? Sent::surface_beside_ground : Sent::surface});
        };
        std::uint32_t number = 0;
        for (const DiscLight& disc : lights_.discs) {
            const auto [u, v, w, x] = sequence(group + ++number % (groups_of_surface - 1));
            if (disc.height > 0) {
                send_light(Across(disc.direction).from(in_cap(disc.height, u, v)), (1 / density_of(disc)) * disc.radiance(), density_of(disc), false);
            } else {
                send_light(disc.direction, pi * disc.color, 0, true);
            }
        }
        const auto [choice, u, v, other] = sequence(group);
        if (const Environment* const environment = lights_.sky.environment.get()) {
            const auto [a, b, c, d] = sequence(group + groups_of_surface - 1);
            const auto [drawn, density] = environment->draw(a, b);
            const Vec3 toward = lights_.sky.from_environment(drawn);
            if (density > 0) send_light(toward, (1 / density) * lights_.sky.radiance(toward), density, false);
        }

        auto drawn = reflection.draw(choice, u, v);
        if (!(drawn.toward.z > 0) || !(luminance(drawn.weight) > 0)) return;
        Vec3 toward = across.from(drawn.toward);
        // Shading normals lean: what would go into the surface is turned back at it.
        if (const float along = dot(toward, met.face); along <= 0) toward = toward - 2 * along * met.face;
        Path on = path;
        if (surface == 0 && asks_for_changes_) on.change = reflection.change_per_radian(drawn.toward);
        on.throughput = product(path.throughput, drawn.weight), on.density = drawn.density, on.from_ground = false;
        if (!drawn.is_mirrored) --on.left;
        go_on({origin, toward}, on, drawn.is_mirrored ? width_ : wide);
        to.is_uncertain = true;
    }

    /// Sends a path on at glass: reflected or refracted, by Fresnel. Lights are not drawn there, but found.
    void pass(const Path& path, const Met& met, const Across& across, Vec3 eye, Vec3 direction, int surface,
              const std::array<float, Sobol::dimensions>& draws) {
        const Material& material = *met.material;
        Path on = path;
        on.density = std::numeric_limits<float>::infinity(), on.through_glass = true, on.from_ground = false;
        const float alpha = squared_roughness(material);
        if (surface == 0) on.change = 1 / alpha;
        const bool is_thin = material.is_thin, is_left = path.media.contains(met.instance), is_straight = is_left && path.media.last() != met.instance;
        if (is_left) on.media.leave(met.instance);
        Media beyond = on.media;
        if (!is_left && !is_thin) beyond.enter(met.instance);
        const float eta = is_thin ? 1 : lighting_.index(path.media) / lighting_.index(beyond);
        bool is_reflected = false;
        Vec3 toward = direction;
        if (!is_straight) {
            const Facets facets(alpha);
            const bool is_rough = alpha > smooth;
            const Vec3 half = is_rough ? facets.draw(eye, draws[1], draws[2]) : Vec3{0, 0, 1};
            const float along = std::min(1.f, dot(eye, half));
            const Boundary boundary = is_thin ? Boundary::sheet(along, Material::rounded(material.ior)) : Boundary(along, eta);
            is_reflected = draws[0] < boundary.reflectance;
            const Vec3 mirrored = 2 * dot(eye, half) * half - eye;
            const Vec3 own = is_reflected ? mirrored : is_thin ? Vec3{mirrored.x, mirrored.y, -mirrored.z} : refracted(eye, half, eta, boundary.beyond);
            if (is_reflected != (own.z > 0)) return;
            if (is_rough) on.throughput = (is_reflected ? facets.joint(eye.z, own.z) : 1) * facets.masking(std::abs(own.z)) * on.throughput;
            if (is_sheet(met) && !is_reflected) {
                on.density = path.density, on.from_ground = path.from_ground;  // straight on, as rays to lights
            } else {
                toward = across.from(own);
                if (const float along = dot(toward, met.face); (along > 0) != is_reflected) toward = toward - 2 * along * met.face;
            }
        }
        on.media = is_reflected ? path.media : beyond;
        if (!is_reflected && !is_left) on.throughput = product(on.throughput, met.color);  // once for each solid
        if (luminance(on.throughput) < min_throughput) return;
        const Vec3 origin = met.point + (is_reflected ? met.start : -met.start) * met.face;
        go_on({origin, toward}, on, width_);
        arrived[path.slot].is_uncertain = true;
    }

    /// The ray straight on through a sheet. Multiplies its light by the probability that a path goes there, and by the colour.
    static Ray through(const Met& met, Vec3 direction, Vec3& light) {
        const Material& sheet = *met.material;
        const float along = std::clamp(-dot(direction, met.normal), 1e-3f, 1.f);
        const float transmitted = 1 - Boundary::sheet(along, Material::rounded(sheet.ior)).reflectance;
        light = product(light, Material::rounded(sheet.transmission) * transmitted * met.color);
        return {met.point - met.start * met.face, direction};
    }

    /// Samples the share of its light that the ground lacks.
    void shade_ground(const Path& path, const Met& met) {
        if (!(lighting_.ground_light_ > 0)) return;
        const Vec3 origin = met.point + met.start * met.face;
        const PixelSequence& sequence = sequences_[path.slot];
        const auto send_light = [&](Vec3 toward, Vec3 color, float light) {
            const float lost = light / lighting_.ground_light_;
            const Ray ray{origin, toward};
            if (!(lost > 0) || !(toward.z > 0) || entry(ray) < 0) return;
            light_rays_.push_back(ray), sent_.push_back({color, 0, lost, path.slot, Sent::ground});
            arrived[path.slot].is_uncertain = true;
        };
        std::uint32_t number = 0;
        for (const DiscLight& disc : lights_.discs) {
            const auto [u, v, w, x] = sequence(1 + ++number % (groups_of_surface - 1));
            const Vec3 toward = disc.height > 0 ? Across(disc.direction).from(in_cap(disc.height, u, v)) : disc.direction;
            // The disc's own mean over the cap is its colour times the cosine, but for its part below the horizon.
            send_light(toward, disc.color, luminance(disc.color) * toward.z * (disc.height > 0 ? 2 / (2 - disc.height) : 1));
        }
        const auto [choice, u, v, other] = sequence(1);
        // A surface that hides the sky reflects light: the path continues there.
        const Ray ray{origin, cosine_weighted(u, v)};
        if (!(ray.direction.z > 0) || entry(ray) < 0) return;
        Path on = path;
        on.to_ground = on.from_ground = true;
        --on.left;
        go_on(ray, on, wide);
        arrived[path.slot].is_uncertain = true;
    }

    /// Adds the light that reaches surfaces, through as many sheets as paths pass.
    void receive(int surface) {
        for (; !light_rays_.empty(); ++surface) {
            const std::vector<float> widths(light_rays_.size());
            const std::vector<std::uint8_t> wants(light_rays_.size());
            lighting_.meet(light_rays_, widths, wants, memory_);
            std::size_t left = 0;
            for (std::size_t i = 0; i < sent_.size(); ++i) {
                const Met& met = memory_.met[i];
                auto& [light, change, lost, slot, to] = sent_[i];
                if (is_sheet(met) && surface + 1 < max_in_glass) {
                    const float whole = luminance(light);
                    const Ray ray = through(met, light_rays_[i].direction, light);
                    const float share = luminance(light) / whole;
                    if (to == Sent::ground) arrived[slot].shadow += (1 - share) * lost;
                    lost *= share;
                    if (!(share > 0)) continue;
                    light_rays_[left] = ray, sent_[left] = sent_[i], ++left;
                } else if (to == Sent::ground) {
                    if (met.kind != Met::sky) arrived[slot].shadow += lost;
                } else if (met.kind == Met::sky) {
                    arrive(slot, light, change, to == Sent::surface_beside_ground);
                }
            }
            light_rays_.resize(left), sent_.resize(left);
        }
    }

    const Lighting& lighting_;
    const Lights& lights_;
    const Projection& projection_;
    float width_;  // of a ray through a pixel
    bool asks_for_changes_;
    Media media_;  // around the camera
    Memory memory_;
    std::vector<PixelSequence> sequences_;
    std::vector<InPicture> places_;
    std::vector<std::size_t> first_rays_;  // of each path, among the first rays
    std::vector<Ray> rays_, next_rays_, light_rays_;
    std::vector<Path> paths_, next_paths_;
    std::vector<float> widths_, next_widths_;
    std::vector<std::uint8_t> wants_, next_wants_;
    std::vector<Sent> sent_;
};

void Lighting::trace(const Camera& camera, int height, int width, std::span<const Pixel> pixels, const Draws& draws, const Layout& layout, float* samples,
                     float* changes) const {
    for (const Channel& channel : layout) {
        constexpr Channel written[] = {channels::mask, channels::gray, channels::depth, channels::normal, channels::color, channels::albedo, channels::shadow, channels::variance};
        if (std::find(std::begin(written), std::end(written), channel) == std::end(written)) {
            throw std::invalid_argument("light has no channel " + std::string(channel.name));
        }
    }
    const Projection projection(camera, height, width);
    const auto components = static_cast<std::size_t>(layout.width());
    const std::uint32_t count = draws.count, runs = std::min(count, max_runs);
    const auto put = [&](float* sample, const Channel& channel, std::initializer_list<float> values) {
        if (const int place = layout.place(channel); place >= 0) std::copy(values.begin(), values.end(), sample + place);
    };
    const std::size_t piece = std::max<std::size_t>(1, paths_at_once / count);
    parallel_for(pixels.size(), piece, [&](std::size_t begin, std::size_t end) {
        Paths paths(*this, projection, draws.apart ? 0.25f : 1.f, changes != nullptr);
        paths.begin((end - begin) * count);
        std::vector<PixelSequence> sequences;
        for (std::size_t i = begin; i < end; ++i) {
            const auto [row, column] = pixels[i];
            sequences.clear();
            for (std::uint32_t k = 0; k < count; ++k) {
                sequences.emplace_back(draws.seed, static_cast<std::uint32_t>(row), static_cast<std::uint32_t>(column), draws.first[i] + k, count);
            }
            const auto down = static_cast<float>(row), right = static_cast<float>(column);
            if (!draws.apart) {
                paths.add(down, right, sequences);
                continue;
            }
            for (const PixelSequence& sequence : sequences) {
                const auto [off_down, off_right, u, v] = sequence(0);
                paths.add(down + (off_down - 0.5f), right + (off_right - 0.5f), {&sequence, 1});
            }
        }
        paths.go();
        for (std::size_t i = begin; i < end; ++i) {
            const std::span<const Arrived> own{&paths.arrived[(i - begin) * count], count};
            Vec3 color, albedo, normal;
            float shadow = 0, depth = 0, change = 0;
            std::array<double, max_runs> run{};
            std::uint32_t hits = 0;
            bool is_uncertain = false;
            for (std::uint32_t k = 0; k < count; ++k) {
                const Arrived& arrived = own[k];
                color = color + arrived.color, shadow += arrived.shadow, change += arrived.change;
                if (arrived.is_hit) ++hits, albedo = albedo + arrived.albedo, normal = normal + arrived.normal, depth += arrived.depth;
                run[std::size_t{k} * runs / count] += static_cast<double>(luminance(arrived.color) + arrived.shadow);
                is_uncertain = is_uncertain || arrived.is_uncertain;
            }
            const float share = 1 / static_cast<float>(count), of_hits = hits ? 1 / static_cast<float>(hits) : 0;
            color = share * color, shadow *= share;
            const double mean = static_cast<double>(luminance(color)) + static_cast<double>(shadow);
            double variance = 0;
            for (std::uint32_t r = 0; runs > 1 && r < runs; ++r) {
                const std::uint32_t from = (r * count + runs - 1) / runs, to = ((r + 1) * count + runs - 1) / runs;
                const double off = run[r] / (to - from) - mean;
                variance += off * off / (runs * (runs - 1.));
            }
            // After n equal outcomes another one is still possible: the rule of succession bounds the variance from below. A tenth of
            // that bound: with all of it, shadows on the ground are a sixth worse (tree, bunny, studio, 10 %). Without it, a few equal
            // samples would count as exact.
            const double unseen = (hits ? static_cast<double>(luminance(color)) : 1.) / (count + 2.);
            if (is_uncertain) variance = std::max(variance, 0.1 * unseen * unseen);
            if (changes) changes[i] = share * change;
            float* const sample = samples + i * components;
            normal = normalized(normal);
            put(sample, channels::mask, {hits ? 1.f : 0.f});
            put(sample, channels::gray, {luminance(color)});
            put(sample, channels::depth, {of_hits * depth});
            put(sample, channels::normal, {normal.x, normal.y});
            put(sample, channels::color, {color.x, color.y, color.z});
            put(sample, channels::albedo, {of_hits * albedo.x, of_hits * albedo.y, of_hits * albedo.z});
            put(sample, channels::shadow, {std::clamp(shadow, 0.f, 1.f)});
            put(sample, channels::variance, {static_cast<float>(variance)});
        }
    });
}

void Lighting::see(const Projection& projection, std::span<const Place> places, float share, float* hits) const {
    struct Own {
        std::vector<std::size_t> number;
        std::vector<Ray> rays;
        std::vector<float> widths;
        std::vector<std::uint8_t> wants;
        Memory memory;
    };
    auto& [number, rays, widths, wants, memory] = thread_memory<Own>();
    number.clear(), rays.clear(), widths.clear();
    std::fill_n(hits, places.size() * first_hit::count, 0.f);
    const float width = share * projection.pixel_width(0.5f);
    for (std::size_t i = 0; i < places.size(); ++i) {
        Ray ray;
        if (!sees(projection, places[i].row, places[i].column, ray)) continue;
        number.push_back(i), rays.push_back(ray), widths.push_back(width / length(ray.direction));
    }
    wants.assign(rays.size(), 1);
    meet(rays, widths, wants, memory);
    for (std::size_t j = 0; j < rays.size(); ++j) {
        const Met& met = memory.met[j];
        float* const to = hits + number[j] * first_hit::count;
        if (met.kind == Met::ground) to[first_hit::ground] = 1, to[first_hit::ground_depth] = projection.unbounded_depth(met.point);
        if (met.kind != Met::surface) continue;
        const Place place = places[number[j]];
        Vec3 normal = projection.on_screen(met.normal, place.row, place.column);
        normal.z = std::max(normal.z, 0.f), normal = normalized(normal);
        const float found[] = {1, projection.depth(met.point), normal.x, normal.y, met.color.x, met.color.y, met.color.z};
        std::copy(std::begin(found), std::end(found), to);
    }
    if (shows_things_) look_behind(projection, places, number, rays, widths, memory, hits);
}

void Lighting::look_behind(const Projection& projection, std::span<const Place> places, std::span<const std::size_t> number, std::span<const Ray> first,
                           std::span<const float> widths, Memory& memory, float* hits) const {
    struct Looked {
        std::size_t at;
        Vec3 tint{1, 1, 1};
        float length = 0;
        Media media;
    };
    const Media around = media_around(projection);
    std::vector<Looked> looked;
    std::vector<Ray> rays(first.begin(), first.end());
    for (std::size_t j = 0; j < first.size(); ++j) looked.push_back({j, {1, 1, 1}, 0, around});
    for (int surface = 0; !looked.empty() && surface <= max_surfaces; ++surface) {
        std::vector<Looked> next;
        std::vector<Ray> next_rays;
        std::vector<float> next_widths;
        for (std::size_t k = 0; k < looked.size(); ++k) {
            Looked on = looked[k];
            const Met& met = memory.met[k];
            float* const to = hits + number[on.at] * first_hit::count;
            if (met.kind == Met::surface && shows_things(*met.material)) {
                const Vec3 direction = normalized(rays[k].direction);
                const float along = std::min(1.f, std::max(1e-3f, -dot(direction, met.normal)));
                Vec3 toward = direction + 2 * along * met.normal;
                bool is_reflected = true;
                if (met.material->transmission >= 0.5 && met.material->is_thin) {
                    if (Boundary::sheet(along, Material::rounded(met.material->ior)).reflectance < 0.5f) is_reflected = false, toward = direction;
                } else if (met.material->transmission >= 0.5) {
                    const bool is_left = on.media.contains(met.instance);
                    Media beyond = on.media;
                    if (is_left) beyond.leave(met.instance);
                    else beyond.enter(met.instance);
                    const float eta = index(on.media) / index(beyond);
                    // The brighter branch.
                    if (const Boundary boundary(along, eta); boundary.reflectance < 0.5f) {
                        is_reflected = false, toward = refracted(-direction, met.normal, eta, boundary.beyond);
                        on.media = beyond;
                    }
                }
                if (is_reflected == (met.material->transmission < 0.5)) on.tint = product(on.tint, met.color);
                on.length += length(met.point - rays[k].origin) * (surface > 0 ? 1.f : 0.f);
                next.push_back(on), next_widths.push_back(widths[on.at]);
                next_rays.push_back({met.point + (is_reflected ? met.start : -met.start) * met.face, toward});
                continue;
            }
            if (surface == 0) continue;
            // The sky is fully known, so the remaining light to complete is white.
            const Vec3 radiance = lights_.radiance(normalized(rays[k].direction));
            const Vec3 own = met.kind == Met::sky ? Vec3{std::min(1.f, radiance.x), std::min(1.f, radiance.y), std::min(1.f, radiance.z)} : met.color;
            const Vec3 tint = product(on.tint, own);
            to[first_hit::behind] = 1, to[first_hit::red] = tint.x, to[first_hit::green] = tint.y, to[first_hit::blue] = tint.z;
            if (met.kind == Met::sky) continue;
            const Place place = places[number[on.at]];
            Vec3 normal = projection.on_screen(met.normal, place.row, place.column);
            normal.z = std::max(normal.z, 0.f), normal = normalized(normal);
            const float beyond = on.length + length(met.point - rays[k].origin);
            const Vec3 seems = projection.point(place.row, place.column, to[first_hit::depth]) + beyond * normalized(first[on.at].direction);
            to[first_hit::depth] = projection.depth(seems), to[first_hit::normal_x] = normal.x, to[first_hit::normal_y] = normal.y;
        }
        looked.swap(next), rays.swap(next_rays);
        const std::vector<std::uint8_t> wants(rays.size(), 1);
        if (!rays.empty()) meet(rays, next_widths, wants, memory);
    }
}

void Lighting::first_hits(const Camera& camera, int height, int width, float* planes) const {
    const Projection projection(camera, height, width);
    constexpr int side = 64;  // of tiles: neighbours visit the same parts of a BVH
    const int across = (width + side - 1) / side, down = (height + side - 1) / side;
    const std::size_t pixels = static_cast<std::size_t>(height) * static_cast<std::size_t>(width);
    parallel_for(static_cast<std::size_t>(across) * static_cast<std::size_t>(down), 1, [&](std::size_t begin, std::size_t end) {
        std::vector<Place> places;
        std::vector<float> hits(std::size_t{side} * side * first_hit::count);
        for (std::size_t tile = begin; tile < end; ++tile) {
            const int top = static_cast<int>(tile) / across * side, left = static_cast<int>(tile) % across * side;
            const int bottom = std::min(top + side, height), right = std::min(left + side, width);
            places.clear();
            constexpr int block = 8;
            for (int row = top; row < bottom; row += block) {
                for (int column = left; column < right; column += block) {
                    for (int y = row; y < std::min(row + block, bottom); ++y) {
                        for (int x = column; x < std::min(column + block, right); ++x) places.push_back({static_cast<float>(y), static_cast<float>(x)});
                    }
                }
            }
            see(projection, places, 1, hits.data());
            for (std::size_t k = 0; k < places.size(); ++k) {
                const std::size_t i = static_cast<std::size_t>(places[k].row) * static_cast<std::size_t>(width) + static_cast<std::size_t>(places[k].column);
                for (std::size_t c = 0; c < first_hit::count; ++c) planes[c * pixels + i] = hits[k * first_hit::count + c];
            }
        }
    });
}

void Lighting::first_hits_within(const Camera& camera, int height, int width, std::span<const Pixel> pixels, int side, float* hits) const {
    const Projection projection(camera, height, width);
    const auto per_pixel = static_cast<std::size_t>(side) * static_cast<std::size_t>(side);
    const float part = 1 / static_cast<float>(side);
    parallel_for(pixels.size(), std::max<std::size_t>(1, paths_at_once / per_pixel), [&](std::size_t begin, std::size_t end) {
        std::vector<Place> places;
        for (std::size_t i = begin; i < end; ++i) {
            for (int down = 0; down < side; ++down) {
                for (int right = 0; right < side; ++right) {
                    const auto off = [=](int k) { return part * (static_cast<float>(k) + 0.5f) - 0.5f; };
                    places.push_back({static_cast<float>(pixels[i].row) + off(down), static_cast<float>(pixels[i].column) + off(right)});
                }
            }
        }
        see(projection, places, part, hits + begin * per_pixel * first_hit::count);
    });
}

}  // namespace bob
