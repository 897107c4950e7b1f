/// glTF 2.0 and GLB: the triangles of a scene in its stored pose, z up.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <span>
#include <utility>

#include "base/interruption.h"
#include "base/vec3d.h"
#include "files/gltf_surfaces.h"
#include "files/placing.h"
#include "files/read.h"
#include "files/text.h"

namespace bob::files {
namespace {

constexpr Rows z_up = {1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0};  // (x, y, z) to (x, -z, y)

Rows placed(const Vec3d& shift, std::array<double, 4> turn, const Vec3d& scale) {
    const double length = std::sqrt(turn[0] * turn[0] + turn[1] * turn[1] + turn[2] * turn[2] + turn[3] * turn[3]);
    if (!(length > 0)) turn = {0, 0, 0, 1};
    for (double& value : turn) value /= length > 0 ? length : 1;
    const auto [x, y, z, w] = turn;
    const auto [s, t, u] = scale;
    return {(1 - 2 * (y * y + z * z)) * s, 2 * (x * y - z * w) * t, 2 * (x * z + y * w) * u, shift[0],
            2 * (x * y + z * w) * s, (1 - 2 * (x * x + z * z)) * t, 2 * (y * z - x * w) * u, shift[1],
            2 * (x * z - y * w) * s, 2 * (y * z + x * w) * t, (1 - 2 * (x * x + y * y)) * u, shift[2]};
}

/// Takes the numbers of a node, if it has them.
void take(std::string_view name, JsonValue node, std::span<double> to) {
    const JsonValue value = node[name];
    if (!value) return;
    if (!value.is_list()) refuse({name, ": expected lists of numbers, got ", value.brief()});
    std::size_t count = 0;
    for (const JsonValue item : value.items()) {
        const std::optional<double> number = item.number();
        if (!number) refuse({name, ": expected lists of numbers, got ", item.brief()});
        if (count < to.size()) to[count] = *number;
        ++count;
    }
    if (count != to.size()) refuse({name, ": expected shape (", std::to_string(to.size()), ",), got (", std::to_string(count), ",)"});
}

Rows place_of(JsonValue node) {
    if (node["matrix"]) {
        std::array<double, 16> m{};  // columns come first
        take("matrix", node, m);
        return {m[0], m[4], m[8], m[12], m[1], m[5], m[9], m[13], m[2], m[6], m[10], m[14]};
    }
    Vec3d shift{}, scale = {1, 1, 1};
    std::array<double, 4> turn = {0, 0, 0, 1};
    take("translation", node, shift);
    take("rotation", node, turn);
    take("scale", node, scale);
    return placed(shift, turn, scale);
}

/// Whether a file that needs this extension can be shown: it is read, refused where it matters, or changes no shape.
bool is_known(std::string_view extension) {
    constexpr std::string_view known[] = {
        "EXT_instance_features", "EXT_lights_image_based", "EXT_mesh_features", "EXT_mesh_gpu_instancing", "EXT_meshopt_compression",
        "EXT_structural_metadata", "EXT_texture_avif", "EXT_texture_webp", "KHR_animation_pointer", "KHR_draco_mesh_compression",
        "KHR_lights_punctual", "KHR_mesh_quantization", "KHR_meshopt_compression", "KHR_node_visibility", "KHR_texture_basisu",
        "KHR_techniques_webgl", "KHR_texture_transform", "KHR_xmp_json_ld", "MSFT_texture_dds"};
    return extension.starts_with("KHR_materials_") || std::ranges::find(known, extension) != std::end(known);
}

/// Extensions that are read, or that do not change the picture.
bool is_shown(std::string_view extension) {
    constexpr std::string_view shown[] = {"EXT_instance_features", "EXT_mesh_features", "EXT_mesh_gpu_instancing", "EXT_structural_metadata",
                                          "KHR_draco_mesh_compression", "KHR_node_visibility", "KHR_xmp_json_ld"};
    return std::ranges::find(shown, extension) != std::end(shown);
}

constexpr std::string_view draco_compression = "KHR_draco_mesh_compression";

enum Mode { points, lines, line_loop, line_strip, triangles, triangle_strip, triangle_fan };

/// The three corners of each triangle of a primitive.
Numbers<std::int32_t> corners_of(const Numbers<std::int32_t>& stored, Mode mode) {
    Numbers<std::int32_t> result;
    if (mode == triangles) {
        result.assign(stored.begin(), stored.end() - static_cast<std::ptrdiff_t>(stored.size() % 3));
        return result;
    }
    for (std::size_t i = 0; i + 2 < stored.size(); ++i) {
        const bool is_odd = i % 2;
        const std::array<std::int32_t, 3> corners = mode == triangle_fan
                                                        ? std::array{stored[i + 1], stored[i + 2], stored[0]}
                                                        : std::array{stored[i], stored[i + 1 + is_odd], stored[i + 2 - is_odd]};
        // Strips repeat a corner where they turn.
        if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0]) continue;
        result.insert(result.end(), corners.begin(), corners.end());
    }
    return result;
}

/// The matrices by which a skin's joints move its mesh.
using Joints = std::vector<Rows>;

/// The reading of one file.
class Scene {
public:
    Scene(GltfData& data, Contents& contents)
        : data_(data), contents_(contents), surfaces_(data, contents, not_shown_), placing_(contents), meshes_(data.list("meshes")), nodes_(data.list("nodes")) {}

    void read();

private:
    /// A primitive in the places of a node.
    struct Drawn {
        std::size_t node;
        JsonValue primitive;
    };

    using Weights = std::vector<std::pair<std::size_t, double>>;  // by the numbers of targets

    void check_extensions() const;
    void check_meshes() const;
    void check_nodes();
    void find_drawn();
    void note(JsonValue extensions);
    void draw(const Drawn& drawn);
    [[nodiscard]] const Weights& weights_of(std::size_t node);
    [[nodiscard]] std::size_t instance_count(JsonValue node) const;
    [[nodiscard]] std::vector<Rows> instances_of(JsonValue node);
    [[nodiscard]] const DracoMesh* draco_mesh(JsonValue stored);
    [[nodiscard]] Numbers<double> numbers(JsonValue stored, std::string_view name, int width, std::optional<bool> is_normalized = {});
    [[nodiscard]] Part read(JsonValue stored, const Weights& weights);
    void morph(Numbers<double>& values, int width, std::string_view name, JsonValue stored, const Weights& weights) const;
    void pose(Part& primitive, JsonValue stored, const Joints& joints);
    [[nodiscard]] const Joints& joints_of(JsonValue skin);
    [[nodiscard]] int label_of(std::size_t node);

    [[nodiscard]] JsonValue mesh_of(std::size_t node) const { return data_.item("meshes", nodes_[node]["mesh"]); }

    GltfData& data_;
    Contents& contents_;
    NotShown not_shown_;
    GltfSurfaces surfaces_;
    Placing placing_;
    const std::vector<JsonValue>&meshes_, &nodes_;
    std::vector<std::size_t> roots_;
    std::vector<Rows> places_;  // of nodes, in the axes of glTF
    std::vector<std::optional<std::size_t>> parents_;  // of nodes
    std::vector<std::optional<int>> labels_;           // of nodes
    std::vector<Drawn> drawn_;
    std::map<std::pair<bool, std::size_t>, Weights> weights_;  // of nodes, and of meshes
    std::map<double, Joints> joints_;   // by the numbers of skins
    std::map<double, DracoMesh> draco_;  // by the numbers of views
};

std::size_t index_of(JsonValue number) { return static_cast<std::size_t>(*number.number()); }

void Scene::read() {
    check_extensions();
    check_meshes();
    check_nodes();
    find_drawn();
    note(data_.root()["extensions"]);
    for (const Drawn& drawn : drawn_) draw(drawn);
    placing_.finish();
    if (data_.list("scenes").size() > 1) not_shown_.add("other scenes");
    if (data_.root()["animations"].size()) not_shown_.add("animations");
    not_shown_.report(contents_, !contents_.parts.empty());
}

void Scene::check_extensions() const {
    for (const JsonValue extension : data_.root()["extensionsRequired"].items()) {
        if (!extension.text() || !is_known(*extension.text())) {
            refuse({"extensionsRequired: expected extensions that are known, got ", extension.brief(), "; export without it"});
        }
    }
}

void Scene::check_meshes() const {
    std::size_t count = 0;
    for (std::size_t i = 0; i < meshes_.size(); ++i) {
        at_item("meshes", i, [&] {
            const JsonValue list = meshes_[i]["primitives"];
            for (const JsonValue primitive : list.items()) {
                if (!primitive.is_object()) refuse({"primitives: expected a list of objects, got another"});
                const JsonValue attributes = primitive["attributes"];
                if (!attributes["POSITION"]) refuse({"attributes: expected a POSITION, got none"});
                const auto last = static_cast<std::int64_t>(data_.list("accessors").size()) - 1;
                for (const auto& [name, value] : attributes.members()) {
                    static_cast<void>(integer(name, value, 0, last));
                    if ((name == "POSITION" || name == "NORMAL") && data_.accessor(value).width != 3) {
                        refuse({name, ": expected vectors of type VEC3, got another"});
                    }
                }
                static_cast<void>(integer("mode", primitive["mode"], points, triangle_fan, triangles));
                if (const JsonValue indices = primitive["indices"]) {
                    static_cast<void>(integer("indices", indices, 0, last));
                    const Accessor& accessor = data_.accessor(indices);
                    if (accessor.width != 1 || accessor.is_float()) refuse({"indices: expected integers, got others"});
                }
            }
            if (!list.is_list()) refuse({"primitives: expected a list of objects, got another"});
            count += list.size();
        });
    }
    check_instances("primitives", count);
}

/// Refuses nodes that do not form a tree: they could be reached in 2^n ways.
void Scene::check_nodes() {
    const auto last = [](const std::vector<JsonValue>& list) { return static_cast<std::int64_t>(list.size()) - 1; };
    parents_.resize(nodes_.size());
    labels_.resize(nodes_.size());
    std::size_t primitives = 0;
    bool is_tree = true;
    const auto listed = [](std::string_view name, JsonValue list) {
        if (list && !list.is_list()) refuse({name, ": expected a list, got ", list.brief()});
        return list.items();
    };
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
        at_item("nodes", i, [&] {
            for (const JsonValue child : listed("children", nodes_[i]["children"])) {
                const auto number = static_cast<std::size_t>(integer("children", child, 0, last(nodes_)));
                is_tree = is_tree && !parents_[number];
                parents_[number] = i;
            }
            if (const JsonValue mesh = nodes_[i]["mesh"]) {
                primitives += meshes_[static_cast<std::size_t>(integer("mesh", mesh, 0, last(meshes_)))]["primitives"].size();
            }
            places_.push_back(place_of(nodes_[i]));
        });
    }
    check_instances("primitives", primitives);
    const std::vector<JsonValue>& scenes = data_.list("scenes");
    std::vector<std::size_t> order;
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
        if (!parents_[i]) order.push_back(i);
    }
    if (!scenes.empty()) {
        const JsonValue scene = scenes[static_cast<std::size_t>(integer("scene", data_.root()["scene"], 0, last(scenes), 0))];
        note(scene["extensions"]);
        for (const JsonValue root : listed("nodes", scene["nodes"])) {
            is_tree = is_tree && !parents_[static_cast<std::size_t>(integer("nodes", root, 0, last(nodes_)))];
            roots_.push_back(index_of(root));
        }
    } else {
        roots_ = order;
    }
    if (!is_tree) refuse({"expected nodes that form a tree, got one with two parents or inside itself"});
    check_instances("nodes", roots_.size());
    // Parents come before their children.
    for (std::size_t at = 0; at < order.size(); ++at) {
        for (const JsonValue child : nodes_[order[at]]["children"].items()) {
            places_[index_of(child)] = product(places_[order[at]], places_[index_of(child)]);
            order.push_back(index_of(child));
        }
    }
}

/// Finds the primitives of all nodes that are shown, and counts them: many can share one accessor.
void Scene::find_drawn() {
    std::size_t placed = 0;
    std::vector<bool> noted(meshes_.size());
    std::vector<std::size_t> left(roots_.rbegin(), roots_.rend());
    while (!left.empty()) {
        const std::size_t number = left.back();
        const JsonValue node = nodes_[number], mesh = mesh_of(number);
        left.pop_back();
        if (node["extensions"]["KHR_node_visibility"]["visible"].truth() == false) continue;
        const std::vector<JsonValue> children = node["children"].items();
        for (std::size_t i = children.size(); i-- > 0;) left.push_back(index_of(children[i]));
        note(node["extensions"]);
        if (!mesh) continue;
        const std::size_t mesh_number = index_of(node["mesh"]);
        const bool is_new = !noted[mesh_number];
        noted[mesh_number] = true;
        if (is_new) note(mesh["extensions"]);
        const std::size_t places = at_item("nodes", number, [&] { return instance_count(node); });
        for (const auto& [name, accessor] : node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"].members()) placing_.count(data_.accessor(accessor).count);
        const std::size_t morphs = weights_of(number).size();
        for (const JsonValue primitive : mesh["primitives"].items()) {
            const auto mode = integer("mode", primitive["mode"], points, triangle_fan, triangles);
            if (mode < triangles) {
                not_shown_.add(mode == points ? "points" : "lines");
                continue;
            }
            if (is_new) note(primitive["extensions"]);
            placed += places;
            check_instances("primitives", placed);
            const std::size_t vertices = data_.accessor(primitive["attributes"]["POSITION"]).count;
            const std::size_t corners = primitive["indices"] ? data_.accessor(primitive["indices"]).count : vertices;
            placing_.count(vertices);
            placing_.count(corners);
            const std::size_t items = vertices + (mode == triangles ? corners / 3 : corners);
            if (morphs) placing_.count(primitive["targets"].size());
            for (std::size_t i = 0; i < places + morphs; ++i) placing_.count(items);
            if (places) drawn_.push_back({number, primitive});
        }
    }
}

void Scene::note(JsonValue extensions) {
    for (const auto& [name, value] : extensions.members()) {
        if (!is_shown(name)) not_shown_.add(name);
    }
}

void Scene::draw(const Drawn& drawn) {
    Interruption::check();
    const JsonValue node = nodes_[drawn.node], attributes = drawn.primitive["attributes"];
    const bool is_skinned = bool(data_.item("skins", node["skin"])) && attributes["JOINTS_0"] && attributes["WEIGHTS_0"];
    if (node["skin"] && !is_skinned) not_shown_.add("invalid skins");
    const std::vector<Rows> instances = instances_of(node);
    Part primitive = at_item("meshes", index_of(node["mesh"]), [&] { return read(drawn.primitive, weights_of(drawn.node)); });
    if (primitive.surface >= 0) {
        const Surface& surface = contents_.surfaces[static_cast<std::size_t>(primitive.surface)];
        if (surface.opacity == Opacity::cutout && surface.alpha_cutoff > 1) return;  // all of it is cut out
    }
    // The joints place a mesh that has a skin; where its own node is does not matter.
    if (is_skinned) pose(primitive, drawn.primitive, at_place("skins", [&]() -> const Joints& { return joints_of(node["skin"]); }));
    const Rows& place = is_skinned ? identity : places_[drawn.node];
    const int label = label_of(drawn.node);
    for (std::size_t i = 0; i + 1 < instances.size(); ++i) placing_.add(primitive, product(z_up, product(place, instances[i])), label);
    placing_.add(std::move(primitive), product(z_up, product(place, instances.back())), label);
}

/// The label of a node. One without a name has its mesh's, or else its parent's.
int Scene::label_of(std::size_t node) {
    std::vector<std::size_t> path;
    std::optional<std::size_t> above = node;
    for (; above && !labels_[*above]; above = parents_[*above]) path.push_back(*above);
    int label = above ? *labels_[*above] : -1;
    for (; !path.empty(); path.pop_back()) {
        std::string name(nodes_[path.back()]["name"].text().value_or(""));
        if (const JsonValue mesh = mesh_of(path.back()); mesh && name.empty()) {
            name = mesh["name"].text().value_or("");
            if (name.empty()) name = "mesh " + std::to_string(index_of(nodes_[path.back()]["mesh"]) + 1);
        }
        if (!name.empty()) label = placing_.label(std::move(name), label);
        labels_[path.back()] = label;
    }
    return label;
}

/// Weights of the mesh's morph targets that are not 0: the node's, or else the mesh's.
const Scene::Weights& Scene::weights_of(std::size_t node) {
    const JsonValue own = nodes_[node]["weights"];
    const auto [at, is_new] = weights_.try_emplace(own.is_list() ? std::pair{true, node} : std::pair{false, index_of(nodes_[node]["mesh"])});
    if (!is_new) return at->second;
    std::size_t target = 0;
    for (const JsonValue weight : (own.is_list() ? own : mesh_of(node)["weights"]).items()) {
        if (const double value = weight.number().value_or(0); value != 0) at->second.emplace_back(target, value);
        ++target;
    }
    return at->second;
}

/// How often a node shows its mesh.
std::size_t Scene::instance_count(JsonValue node) const {
    const JsonValue attributes = node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
    std::optional<std::size_t> result;
    for (const std::string_view name : {"TRANSLATION", "ROTATION", "SCALE"}) {
        if (attributes[name]) result = std::min(result.value_or(max_items), data_.accessor(attributes[name]).count);
    }
    check_instances("primitives", result.value_or(1));
    return result.value_or(1);
}

std::vector<Rows> Scene::instances_of(JsonValue node) {
    const JsonValue attributes = node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
    std::vector<Rows> result(instance_count(node), identity);
    const auto values = [&](std::string_view name, int width, double otherwise, double last) {
        Numbers<double> numbers;
        if (attributes[name] && data_.accessor(attributes[name]).width == width) {
            Accessor accessor = data_.accessor(attributes[name]);
            return data_.numbers(accessor, width);
        }
        for (std::size_t i = 0; i < result.size(); ++i) {
            for (int k = 0; k < width; ++k) numbers.push_back(k == width - 1 ? last : otherwise);
        }
        return numbers;
    };
    if (attributes["_COLOR_0"]) not_shown_.add("colours of instances");
    const Numbers<double> shifts = values("TRANSLATION", 3, 0, 0), turns = values("ROTATION", 4, 0, 1), scales = values("SCALE", 3, 1, 1);
    for (std::size_t i = 0; i < result.size(); ++i) {
        result[i] = placed({shifts[3 * i], shifts[3 * i + 1], shifts[3 * i + 2]}, {turns[4 * i], turns[4 * i + 1], turns[4 * i + 2], turns[4 * i + 3]},
                           {scales[3 * i], scales[3 * i + 1], scales[3 * i + 2]});
    }
    return result;
}

/// A primitive's compressed mesh, unless its numbers are stored plainly too.
const DracoMesh* Scene::draco_mesh(JsonValue stored) {
    const JsonValue compressed = stored["extensions"][draco_compression], vertices = stored["attributes"]["POSITION"], indices = stored["indices"];
    const auto is_missing = [&](JsonValue accessor) { return accessor && !data_.accessor(accessor).view && !data_.accessor(accessor).sparse; };
    if (!compressed || !(is_missing(vertices) || is_missing(indices))) return nullptr;
    return at_place(draco_compression, [&] {
        const auto [at, is_new] = draco_.try_emplace(compressed["bufferView"].number().value_or(-1));
        const std::size_t points = data_.accessor(vertices).count, corners = indices ? data_.accessor(indices).count : points;
        const bool is_list = integer("mode", stored["mode"], triangles, triangle_fan, triangles) == triangles;
        if (is_new) at->second = data_.draco_mesh(compressed, is_list ? corners / 3 : corners);
        if (at->second.points != points) {
            refuse({"expected ", grouped(points), " vertices, as its accessor says, got ", grouped(at->second.points)});
        }
        return &at->second;
    });
}

/// An attribute's numbers, `width` of each vertex. is_normalized: if omitted, as its accessor says.
Numbers<double> Scene::numbers(JsonValue stored, std::string_view name, int width, std::optional<bool> is_normalized) {
    Accessor accessor = data_.accessor(stored["attributes"][name]);
    accessor.normalized = is_normalized.value_or(accessor.normalized);
    const DracoMesh* const mesh = draco_mesh(stored);
    const std::optional<double> id = stored["extensions"][draco_compression]["attributes"][name].number();
    if (!mesh || !id) return data_.numbers(accessor, width);
    const auto found = std::ranges::find_if(mesh->attributes, [&](const DracoMesh::Attribute& attribute) { return attribute.id == *id; });
    const auto across = static_cast<std::size_t>(width);
    if (found == mesh->attributes.end() || found->width < across) refuse({draco_compression, ": expected data of ", name, ", got none"});
    Numbers<double> result;
    for (std::size_t i = 0; i < found->values.size(); i += found->width) {
        result.insert(result.end(), &found->values[i], &found->values[i] + across);
    }
    if (accessor.normalized) normalize(result, found->component);
    return result;
}

Part Scene::read(JsonValue stored, const Weights& weights) {
    const JsonValue attributes = stored["attributes"];
    const std::size_t count = data_.accessor(attributes["POSITION"]).count;
    const auto found = [&](const std::string& name, int low, int high) -> const Accessor* {
        const Accessor* const accessor = attributes[name] ? &data_.accessor(attributes[name]) : nullptr;
        return accessor && accessor->count == count && accessor->width >= low && accessor->width <= high ? accessor : nullptr;
    };
    const auto name_of = [](int set) { return "TEXCOORD_" + std::to_string(set); };
    Part result;
    result.surface = surfaces_.number(stored["material"], [&](int set) { return found(name_of(set), 2, 2) != nullptr; });
    result.vertices = numbers(stored, "POSITION", 3);
    morph(result.vertices, 3, "POSITION", stored, weights);
    const auto shown = [&](std::string_view name, int low, int high) {
        const Accessor* const accessor = found(std::string(name), low, high);
        if (!accessor && attributes[name]) not_shown_.add(joined({"invalid ", name}));
        return accessor;
    };
    if (shown("NORMAL", 3, 3)) {
        result.normals = numbers(stored, "NORMAL", 3);
        morph(result.normals, 3, "NORMAL", stored, weights);
    }
    if (const Accessor* const colors = shown("COLOR_0", 3, 4)) {
        Numbers<double> values = numbers(stored, "COLOR_0", colors->width, true);
        morph(values, colors->width, "COLOR_0", stored, weights);
        for (double& value : values) value = std::clamp(value, 0., 1.);
        const auto width = static_cast<std::size_t>(colors->width);
        const bool is_cut = result.surface >= 0 && contents_.surfaces[static_cast<std::size_t>(result.surface)].opacity == Opacity::cutout;
        for (std::size_t i = 0; i < count; ++i) {
            for (std::size_t k = 0; k < 3; ++k) result.colors.push_back(values[width * i + k]);
            if (width == 4 && is_cut) result.alphas.push_back(values[width * i + 3]);
        }
    }
    if (result.surface >= 0) {
        for (const UvSet& set : surfaces_.uv_sets(result.surface)) {
            Numbers<double>& places = result.uv.emplace_back(numbers(stored, name_of(set.texcoord), 2));
            morph(places, 2, name_of(set.texcoord), stored, weights);
            const auto& [a, b, c, d, e, f] = set.map;
            for (std::size_t i = 0; i < places.size(); i += 2) {
                const double u = places[i], v = places[i + 1];
                places[i] = a * u + b * v + c;
                places[i + 1] = d * u + e * v + f;
            }
        }
    }
    if (const DracoMesh* const mesh = draco_mesh(stored)) {
        result.triangles = mesh->triangles;
        return result;
    }
    Numbers<std::int32_t> corners;
    if (stored["indices"]) {
        corners = data_.indices(data_.accessor(stored["indices"]));
    } else {
        corners.resize(count);
        for (std::size_t i = 0; i < count; ++i) corners[i] = static_cast<std::int32_t>(i);
    }
    result.triangles = corners_of(corners, static_cast<Mode>(integer("mode", stored["mode"], points, triangle_fan, triangles)));
    return result;
}

/// Adds the changes of the morph targets.
void Scene::morph(Numbers<double>& values, int width, std::string_view name, JsonValue stored, const Weights& weights) const {
    if (weights.empty()) return;
    const std::vector<JsonValue> targets = stored["targets"].items();
    for (const auto& [target, weight] : weights) {
        if (target >= targets.size() || !targets[target][name]) continue;
        const Accessor& accessor = data_.accessor(targets[target][name]);
        if (accessor.width != width || static_cast<std::size_t>(width) * accessor.count != values.size()) {
            refuse({"targets: expected a vector of type VEC", std::to_string(width), " for each vertex, got others"});
        }
        const Numbers<double> changes = data_.numbers(accessor, width);
        for (std::size_t k = 0; k < values.size(); ++k) values[k] += weight * changes[k];
    }
}

/// Moves vertices by the weighted mean of their joints' matrices. NaN, which is left out later, where a joint is missing.
void Scene::pose(Part& primitive, JsonValue stored, const Joints& joints) {
    const JsonValue attributes = stored["attributes"];
    const std::size_t count = primitive.vertices.size() / 3;
    std::vector<Rows> moves(count, Rows{});
    std::vector<double> sums(count);
    for (int set = 0; set < 64; ++set) {
        const std::string name_of_joints = "JOINTS_" + std::to_string(set), name_of_weights = "WEIGHTS_" + std::to_string(set);
        const JsonValue held = attributes[name_of_joints], weight = attributes[name_of_weights];
        if (!held || !weight) break;
        const Accessor &of_joints = data_.accessor(held), &of_weights = data_.accessor(weight);
        if (of_joints.count != count || of_weights.count != count || of_joints.width != 4 || of_weights.width != 4) {
            refuse({"JOINTS: expected four joints and weights for each vertex, got others"});
        }
        const Numbers<double> weights = numbers(stored, name_of_weights, 4, true), joint_numbers = numbers(stored, name_of_joints, 4, false);
        for (std::size_t i = 0; i < weights.size(); ++i) {
            if (weights[i] == 0) continue;
            const bool is_there = joint_numbers[i] >= 0 && joint_numbers[i] < static_cast<double>(joints.size());
            sums[i / 4] += is_there ? weights[i] : nan;
            if (!is_there) continue;
            const Rows& joint = joints[static_cast<std::size_t>(joint_numbers[i])];
            for (std::size_t k = 0; k < joint.size(); ++k) moves[i / 4][k] += weights[i] * joint[k];
        }
    }
    for (std::size_t i = 0; i < count; ++i) {
        if (i % 65536 == 0) Interruption::check();
        Rows move = sums[i] == 0 ? joints.at(0) : moves[i];
        if (sums[i] != 0) {
            for (double& value : move) value /= sums[i];
        }
        const Vec3d to = moved(move, &primitive.vertices[3 * i]);
        std::ranges::copy(to, &primitive.vertices[3 * i]);
        if (primitive.normals.empty()) continue;
        const Vec3d normal = moved(of_normals(move).first, &primitive.normals[3 * i], 0);
        std::ranges::copy(normal, &primitive.normals[3 * i]);
    }
}

/// The places of a skin's joints in the scene, after their inverse bind matrices.
const Joints& Scene::joints_of(JsonValue skin) {
    const auto [at, is_new] = joints_.try_emplace(*skin.number());
    Joints& result = at->second;
    if (!is_new) return result;
    const JsonValue stored = data_.item("skins", skin), matrices = stored["inverseBindMatrices"];
    for (const JsonValue joint : stored["joints"].items()) {
        result.push_back(places_[static_cast<std::size_t>(integer("joints", joint, 0, static_cast<std::int64_t>(nodes_.size()) - 1))]);
    }
    if (result.empty()) refuse({"joints: expected at least one, got none"});
    if (!matrices) return result;
    const Accessor& accessor = data_.accessor(matrices);
    if (accessor.width != 16 || accessor.count < result.size()) {
        refuse({"inverseBindMatrices: expected a matrix of type MAT4 for each joint, got others"});
    }
    placing_.count(accessor.count);
    const Numbers<double> m = data_.numbers(accessor, 16);
    for (std::size_t i = 0; i < result.size(); ++i) {
        Rows inverse;
        for (std::size_t k = 0; k < inverse.size(); ++k) inverse[k] = m[16 * i + 4 * (k % 4) + k / 4];  // columns come first
        result[i] = product(result[i], inverse);
    }
    return result;
}

Contents read(Bytes text, std::optional<Bytes> chunk, Beside& beside) {
    GltfData data(text, chunk, beside);
    Contents contents;
    if (!beside.is_waiting()) Scene(data, contents).read();
    contents.unit = "m";
    return contents;
}

std::uint32_t number_at(Bytes bytes, std::size_t at) {
    return bytes[at] | std::uint32_t{bytes[at + 1]} << 8 | std::uint32_t{bytes[at + 2]} << 16 | std::uint32_t{bytes[at + 3]} << 24;
}

std::string_view name_at(Bytes bytes, std::size_t at) {
    return {reinterpret_cast<const char*>(bytes.data()) + at, std::min<std::size_t>(4, bytes.size() - at)};
}

void expect_bytes(std::string_view says, std::uint64_t expected, std::uint64_t got) {
    refuse({"expected ", grouped(expected), " bytes, as ", says, " says, got ", grouped(got)});
}

}  // namespace

Contents read_gltf(Bytes bytes, Beside& beside) { return read(bytes, std::nullopt, beside); }

Contents read_glb(Bytes bytes, Beside& beside) {
    constexpr std::size_t head = 12, chunk_head = 8;
    if (bytes.size() < head + chunk_head || name_at(bytes, 0) != "glTF") {
        refuse({"expected a GLB, which starts with 'glTF', got ", quoted(name_at(bytes, 0))});
    }
    const std::uint32_t version = number_at(bytes, 4);
    if (version != 2) refuse({"expected a GLB of version 2, got ", std::to_string(version), "; export it as glTF 2.0"});
    const std::uint64_t size = number_at(bytes, 8), start = head + chunk_head, end = start + number_at(bytes, head);
    if (size > bytes.size() || end > size) expect_bytes("its head", std::max(size, end), bytes.size());
    if (name_at(bytes, 16) != "JSON") refuse({"expected a first chunk of JSON, got one of ", quoted(name_at(bytes, 16))});
    // A buffer without a name is the chunk of this kind after the JSON; other chunks are ignored.
    Bytes chunk;
    if (end + chunk_head <= size && name_at(bytes, end + 4) == std::string_view("BIN\0", 4)) {
        const std::uint64_t length = number_at(bytes, end), last = end + chunk_head + length;
        if (last > size) expect_bytes("a chunk's head", last, size);
        chunk = bytes.subspan(end + chunk_head, length);
    }
    return read(bytes.subspan(start, end - start), chunk, beside);
}

}  // namespace bob::files
