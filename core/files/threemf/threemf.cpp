/// 3MF, a package of XML: objects and their placements, colours of triangles, textures, beams and formulas.
#include <algorithm>
#include <map>
#include <set>
#include <stdexcept>
#include <tuple>

#include "base/counts.h"
#include "files/placing.h"
#include "files/read.h"
#include "files/text.h"
#include "files/threemf/model.h"

namespace bob::files::threemf {
namespace {

/// The surfaces of textures; unreadable ones are left out, with a warning.
class Textures {
public:
    Textures(Package& package, Contents& contents) : package_(package), contents_(contents) {}

    /// The number of a texture's surface; -1 if it was left out.
    int surface(const Texture* texture) {
        const Texture chosen = texture ? *texture : Texture{};
        const int number = image(chosen.path);
        if (number < 0) return -1;
        const auto [found, is_new] = surfaces_.try_emplace({number, chosen.across, chosen.down}, static_cast<int>(contents_.surfaces.size()));
        if (is_new) contents_.surfaces.emplace_back().color = {.image = number, .across = chosen.across, .down = chosen.down};
        return found->second;
    }

private:
    int image(const std::string& path) {
        const auto [found, is_new] = images_.try_emplace(path, -1);
        if (!is_new) return found->second;
        const std::string label = path.empty() ? "without a path" : path;
        try {
            const auto part = package_.part(path);
            if (path.empty() || !part) refuse({"expected a picture in the file, found none of that name"});
            const Numbers<std::uint8_t> bytes = package_.unpacked("pictures", *part);
            contents_.images.push_back({.name = {}, .bytes = {bytes.begin(), bytes.end()}, .label = label});
            found->second = static_cast<int>(contents_.images.size()) - 1;
        } catch (const std::invalid_argument& error) {
            contents_.warnings.push_back(joined({"texture ", label, " was left out: ", error.what()}));
        }
        return found->second;
    }

    Package& package_;
    Contents& contents_;
    std::map<std::string, int> images_;  // by their paths
    std::map<std::tuple<int, Wrap, Wrap>, int> surfaces_;
};

/// The objects of all models that the root names, and what that builds.
struct Read {
    std::map<Key, Object> objects;
    std::vector<Reference> built;
    std::string_view unit;
};

Read read_models(Package& package, LeftOut& left) {
    const auto root = package.root();
    if (!root) refuse({"expected a 3MF with a 3D/3dmodel.model in it, got none"});
    Read result;
    std::vector<std::size_t> open = {*root};
    std::set<std::size_t> known = {*root};
    while (!open.empty()) {
        const std::size_t number = open.back();
        open.pop_back();
        Model model = read_model(package, number, left);
        result.objects.merge(model.objects);
        if (number == *root) {  // other models' builds are for them alone
            result.built = std::move(model.built);
            result.unit = model.unit;
        }
        for (const std::size_t other : model.named) {
            if (known.insert(other).second) open.push_back(other);
        }
    }
    return result;
}

/// Places the build: components are placed relative to their object.
void place(Read& read, Package& package, Contents& contents) {
    struct Open {
        const Reference* reference;
        Rows place;
        int parent;  // label
    };
    /// An object's content, once it is needed.
    struct Made {
        std::vector<Part> parts;
        std::vector<std::size_t> shapes;  // numbers
    };
    Textures textures(package, contents);
    Placing placing(contents);
    std::map<const Object*, Made> made;
    std::vector<Open> open;
    const auto add = [&](const std::vector<Reference>& references, const Rows& parent, int label) {
        for (std::size_t i = references.size(); i-- > 0;) open.push_back({&references[i], product(parent, references[i].place), label});
    };
    add(read.built, identity, -1);
    for (std::size_t visited = 0; !open.empty();) {
        const Open next = open.back();
        open.pop_back();
        const auto found = read.objects.find(next.reference->key);
        if (found == read.objects.end()) refuse({"expected an object with id ", next.reference->key.second, ", found none"});
        if (++visited + open.size() > max_instances) refuse({"expected finitely many components, got too many; does one hold itself?"});
        Object& object = found->second;
        const auto [own, is_new] = made.try_emplace(&object);
        if (is_new) {
            own->second.parts = object.palette->parts(std::move(object.mesh), [&](const Texture* texture) { return textures.surface(texture); });
            for (OtherShape& shape : object.shapes) {
                own->second.shapes.push_back(contents.shapes.size());
                contents.shapes.push_back(std::move(shape));
            }
        }
        const int label = placing.label(object.name, next.parent);
        for (const Part& part : own->second.parts) {
            placing.count((part.triangles.size() + part.vertices.size()) / 3);
            if (!part.vertices.empty()) placing.add(part, next.place, label);
        }
        for (const std::size_t shape : own->second.shapes) contents.placements.push_back({shape, label, next.place});
        if (contents.placements.size() > max_instances) {
            refuse({"expected at most ", grouped(max_instances), " beam lattices and formulas, got more"});
        }
        add(object.components, next.place, label);
    }
    placing.finish();
}

Contents read_package(Bytes bytes) {
    Package package(bytes);
    Contents contents;
    LeftOut left;
    Read read = read_models(package, left);
    place(read, package, contents);
    contents.unit = read.unit;
    if (const std::string names = left.names(); !names.empty()) {
        if (contents.parts.empty() && contents.placements.empty()) refuse({"expected triangles, got none; left out ", names});
        contents.warnings.push_back("left out " + names);
    }
    return contents;
}

}  // namespace
}  // namespace bob::files::threemf

bob::files::Contents bob::files::read_3mf(Bytes bytes, Beside&) { return threemf::read_package(bytes); }
