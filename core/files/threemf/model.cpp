#include "files/threemf/model.h"

#include <algorithm>
#include <array>
#include <stdexcept>

#include "files/placing.h"
#include "files/text.h"
#include "files/xml.h"

namespace bob::files::threemf {
namespace {

/// Usual prefixes of the known extensions, by namespace. Meshes are right without the unread ones.
constexpr std::pair<std::string_view, std::string_view> extensions[] = {
    {"http://schemas.microsoft.com/3dmanufacturing/material/2015/02", "m:"},
    {"http://schemas.microsoft.com/3dmanufacturing/production/2015/06", "p:"},
    {"http://schemas.microsoft.com/3dmanufacturing/slice/2015/07", "s:"},
    {"http://schemas.microsoft.com/3dmanufacturing/beamlattice/2017/02", "b:"},
    {"http://schemas.microsoft.com/3dmanufacturing/beamlattice/balls/2020/07", "b2:"},
    {"http://schemas.microsoft.com/3dmanufacturing/trianglesets/2021/07", "t:"},
    {"http://schemas.microsoft.com/3dmanufacturing/displacement/2022/07", "d:"},
    {"http://schemas.3mf.io/3dmanufacturing/displacement/2023/10", "d:"},
    {"http://schemas.3mf.io/3dmanufacturing/booleanoperations/2023/07", "bo:"},
    {"http://schemas.3mf.io/3dmanufacturing/volumetric/2022/01", "v:"},
    {"http://schemas.3mf.io/3dmanufacturing/implicit/2023/12", "i:"},
};

/// Names of unread elements in the warning.
constexpr std::pair<std::string_view, std::string_view> not_shown[] = {
    {"m:multiproperties", "multiproperties"},
    {"m:pbspeculardisplayproperties", "display properties"},
    {"m:pbmetallicdisplayproperties", "display properties"},
    {"m:pbspeculartexturedisplayproperties", "display properties"},
    {"m:pbmetallictexturedisplayproperties", "display properties"},
    {"m:translucentdisplayproperties", "display properties"},
    {"d:displacementmesh", "displacements"},
    {"bo:booleanshape", "Boolean operations"},
    {"v:composite", "mixtures of materials"},
    {"v:property", "properties in space"},
};

constexpr std::pair<std::string_view, std::string_view> units[] = {
    {"micron", "um"}, {"millimeter", "mm"}, {"centimeter", "cm"}, {"meter", "m"}, {"inch", "in"}, {"foot", "ft"},
};

/// The second of a pair by its first; empty if there is none.
template <class Pairs>
std::string_view second_of(const Pairs& pairs, std::string_view first) {
    const auto found = std::ranges::find(pairs, first, [](const auto& pair) { return pair.first; });
    return found == std::end(pairs) ? std::string_view() : found->second;
}

std::string_view needed_of(std::string_view element, const XmlAttributes& get, std::string_view name) {
    const auto found = get.find(name);
    if (!found) refuse({element, ": expected the attribute ", name, ", got none"});
    return *found;
}

double number_at(std::string_view element, const XmlAttributes& get, std::string_view name) {
    return number_of(trimmed(needed_of(element, get, name)));
}

/// The 12 numbers of a transform, which 3MF multiplies from the right.
Rows place_of(const XmlAttributes& get) {
    Rows result = identity;
    const std::vector<double> values = numbers_of(get.get("transform"));
    if (values.empty()) return result;
    if (values.size() != 12) refuse({"transform: expected 12 numbers, got ", std::to_string(values.size())});
    for (std::size_t i = 0; i < 12; ++i) result[4 * (i % 3) + i / 3] = values[i];
    return result;
}

/// The wrap mode of a texture along an axis; `none` is read as clamp.
Wrap wrap_of(std::string_view style) { return style == "mirror" ? Wrap::mirror : style == "clamp" || style == "none" ? Wrap::clamp : Wrap::repeat; }

/// A level set's attributes, until all functions are known.
struct StoredLevelSet {
    std::string id, name, function, channel, mesh, volume;
    bool is_box;
    Rows place;
    Rgb color;
};

/// The reading of one model.
class ModelReader {
public:
    ModelReader(Package& package, std::size_t number, LeftOut& left)
        : package_(package), number_(number), left_(left), palette_(std::make_shared<Palette>()),
          functions_([this](std::string_view id) { return mesh_of(id); }) {}

    Model read() && {
        const Numbers<std::uint8_t> text = package_.unpacked("a 3MF model", number_);
        Xml xml(text);
        for (auto event = xml.next(); event != Xml::Event::finish; event = xml.next()) {
            if (event == Xml::Event::start) {
                start(xml);
            } else {
                end(xml);
            }
        }
        for (const StoredLevelSet& stored : level_sets_) add(stored);
        return std::move(model_);
    }

private:
    void start_model(const Xml& xml) {
        if (xml.name() != "model") refuse({"expected a 3MF model, got the element ", xml.name()});
        core_ = xml.space();
        is_started_ = true;
        const XmlAttributes& get = xml.attributes();
        if (const std::string_view unit = second_of(units, lower(get.get("unit"))); !unit.empty()) model_.unit = unit;
        Words prefixes(get.get("requiredextensions"));
        for (std::string_view prefix = prefixes.next(); !prefix.empty(); prefix = prefixes.next()) {
            const std::string_view space = xml.space_of(prefix);
            if (space != core_ && second_of(extensions, space).empty()) {
                refuse({"requiredextensions: expected supported extensions, got ", space.empty() ? prefix : space});
            }
        }
    }

    void start(const Xml& xml) {
        if (!is_started_) start_model(xml);
        const XmlAttributes& get = xml.attributes();
        if (xml.space() == core_) return start_core(xml.name(), get);
        const std::string_view prefix = second_of(extensions, xml.space());
        if (prefix.empty()) return;
        if (prefix == "i:") return functions_.start(xml.name(), get);
        if (prefix == "d:" && (xml.name() == "vertex" || xml.name() == "triangle")) return start_core(xml.name(), get);
        start_extension(joined({prefix, xml.name()}), get);
    }

    void start_core(std::string_view kind, const XmlAttributes& get) {
        if (kind == "vertex") {
            for (const std::string_view axis : {"x", "y", "z"}) object_.mesh.vertices.push_back(number_at(kind, get, axis));
        } else if (kind == "triangle") {
            for (const std::string_view corner : {"v1", "v2", "v3"}) object_.mesh.triangles.push_back(index_of(number_at(kind, get, corner)));
            Swatches swatches;
            swatches.fill(swatch_);
            if (const auto first = get.find("p1")) {
                const std::string_view group = get.get("pid", group_);
                const auto swatch = [&](std::string_view corner) { return palette_->swatch(group, get.get(corner, *first)); };
                swatches = {swatch("p1"), swatch("p2"), swatch("p3")};
            }
            object_.mesh.chosen.push_back(swatches);
            if (get.all().size() == 3) return;
            for (const XmlAttributes::Attribute& attribute : get.all()) {  // of Bambu Studio, and of PrusaSlicer
                left_.add("painted colours of slicers", attribute.name == "paint_color" || attribute.name == "mmu_segmentation");
            }
        } else if (kind == "component") {
            object_.components.push_back(reference(kind, get));
        } else if (kind == "item") {
            model_.built.push_back(reference(kind, get));
        } else if (kind == "object") {
            start_object(needed_of(kind, get, "id"), get);
        } else if (kind == "basematerials") {
            palette_->start(get.get("id"), true);
        } else if (kind == "base") {
            palette_->add(get.get("displaycolor"));
        }
    }

    void start_extension(std::string_view kind, const XmlAttributes& get) {
        if (kind == "m:colorgroup") {
            palette_->start(get.get("id"));
        } else if (kind == "m:color") {
            palette_->add(get.get("color"));
        } else if (kind == "m:compositematerials") {
            palette_->start_mixtures(get.get("id"), get.get("matid"), get.get("matindices"));
        } else if (kind == "m:composite") {
            palette_->add_mixture(get.get("values"));
        } else if (kind == "m:texture2d") {
            palette_->add_texture(get.get("id"), {std::string(get.get("path")), wrap_of(get.get("tilestyleu")), wrap_of(get.get("tilestylev"))});
        } else if (kind == "m:texture2dgroup") {
            palette_->start_places(get.get("id"), get.get("texid"));
        } else if (kind == "m:tex2coord") {
            palette_->add_place(needed_of("tex2coord", get, "u"), needed_of("tex2coord", get, "v"));
        } else if (kind == "b:beamlattice") {
            lattice_.emplace(get, group_, color_number_, *palette_);
        } else if (kind == "b:beam" && lattice_) {
            lattice_->add_beam(get, needed_of("beam", get, "v1"), needed_of("beam", get, "v2"));
        } else if (kind == "b2:ball" && lattice_) {
            lattice_->add_ball(get, needed_of("ball", get, "vindex"));
        } else if (kind == "v:functionfromimage3d") {
            functions_.add_image(get.get("id"));
        } else if (kind == "v:volumedata") {
            volume_ = get.get("id");
        } else if (kind == "v:color") {
            const auto text = [&](std::string_view name) { return std::string(needed_of("color", get, name)); };
            color_of_.insert_or_assign(volume_, FunctionOutput{text("functionid"), text("channel"), place_of(get)});
        } else if (kind == "v:levelset") {
            Swatches swatches;
            swatches.fill(swatch_);
            const auto text = [&](std::string_view name) { return std::string(needed_of("levelset", get, name)); };
            const std::string_view box = get.get("meshbboxonly");
            level_sets_.push_back({.id = id_, .name = name_, .function = text("functionid"), .channel = text("channel"), .mesh = text("meshid"),
                                   .volume = std::string(get.get("volumeid")), .is_box = box == "true" || box == "1", .place = place_of(get),
                                   .color = palette_->of(swatches)[0]});
        } else {
            left_.add(second_of(not_shown, kind), second_of(not_shown, kind).empty() ? 0 : 1);
        }
    }

    void start_object(std::string_view id, const XmlAttributes& get) {
        object_ = {};
        lattice_.reset();
        id_ = id;
        name_ = get.get("name");
        group_ = get.get("pid");
        color_number_ = get.get("pindex");
        object_.name = trimmed(name_.empty() ? get.get("partnumber") : name_);
        if (object_.name.empty()) object_.name = "object " + id_;
        swatch_ = get.find("pid") ? palette_->swatch(group_, color_number_) : Swatch{};
        for (const XmlAttributes::Attribute& attribute : get.all()) {
            const bool is_coarse = attribute.name == "meshresolution" && attribute.value == "lowres" && second_of(extensions, attribute.space) == "s:";
            left_.add("slices of coarse meshes", is_coarse);
        }
    }

    void end(const Xml& xml) {
        if (xml.space() == core_ && xml.name() == "object") return end_object();
        if (second_of(extensions, xml.space()) == "i:") functions_.end(xml.name());
    }

    void end_object() {
        if (lattice_) {
            object_.shapes = lattice_->shapes(object_.mesh.vertices, left_);
            for (OtherShape& shape : object_.shapes) shape.name = name_;
            if (!object_.shapes.empty() && object_.mesh.triangles.empty()) object_.mesh.vertices.clear();
        }
        object_.palette = palette_;
        model_.objects.insert_or_assign({number_, id_}, std::move(object_));
        object_ = {};
        lattice_.reset();
        id_.clear(), name_.clear(), group_.clear(), color_number_.clear();
        swatch_ = {};
    }

    /// Adds a level set to its object.
    void add(const StoredLevelSet& stored) {
        if (functions_.is_image(stored.function)) return left_.add("level sets of images");
        LevelSet made = at_place("levelset", [&] {
            return functions_.level_set({stored.function, stored.channel, stored.place}, {stored.mesh, stored.is_box});
        });
        made.color = color_of(stored.volume);
        Object& object = model_.objects[{number_, stored.id}];
        object.palette = palette_;
        object.shapes.push_back({stored.name, stored.color, std::move(made)});
    }

    std::shared_ptr<const ColorFormula> color_of(std::string_view volume) {
        const auto found = color_of_.find(volume);
        if (found == color_of_.end()) return nullptr;
        if (functions_.is_image(found->second.function)) {
            left_.add("colours of images in space");
            return nullptr;
        }
        return at_place("color", [&] { return std::make_shared<const ColorFormula>(functions_.color(found->second)); });
    }

    /// The mesh of an object; null if there is none.
    const Mesh* mesh_of(std::string_view id) const {
        const auto found = model_.objects.find({number_, std::string(id)});
        return found == model_.objects.end() ? nullptr : &found->second.mesh;
    }

    Reference reference(std::string_view kind, const XmlAttributes& get) {
        Key key{number_, std::string(needed_of(kind, get, "objectid"))};
        for (const XmlAttributes::Attribute& attribute : get.all()) {
            if (attribute.name != "path" || second_of(extensions, attribute.space) != "p:") continue;
            const auto found = package_.part(attribute.value);
            key.first = found.value_or(static_cast<std::size_t>(-1));
            if (found) {
                model_.named.push_back(*found);
            } else {
                key.second += joined({" in ", quoted(attribute.value)});  // for the message: no object has this id
            }
        }
        return {std::move(key), place_of(get)};
    }

    Package& package_;
    const std::size_t number_;
    LeftOut& left_;
    Model model_;
    std::shared_ptr<Palette> palette_;
    Functions functions_;
    bool is_started_ = false;
    std::string core_;  // namespace of the elements without an extension
    Object object_;     // that takes elements
    std::string id_, name_, group_, color_number_;  // its attributes
    Swatch swatch_;
    std::optional<Lattice> lattice_;
    std::vector<StoredLevelSet> level_sets_;
    std::string volume_;  // the id of the volume that takes colours
    std::map<std::string, FunctionOutput, std::less<>> color_of_;  // by the ids of volumes
};

}  // namespace

Model read_model(Package& package, std::size_t number, LeftOut& left) { return ModelReader(package, number, left).read(); }

}  // namespace bob::files::threemf
