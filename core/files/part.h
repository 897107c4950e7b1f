/// Readers of mesh files turn bytes into parts, surfaces and warnings. The hosts decode images and fetch files next to the model.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <new>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "base/box.h"
#include "formula/expression.h"
#include "shapes/mesh/texture.h"
#include "tracing/material.h"

namespace bob::files {

using Bytes = std::span<const std::uint8_t>;

/// Leaves new numbers unset, which readers set right away.
template <class T>
struct Unset : std::allocator<T> {
    template <class U>
    struct rebind {
        using other = Unset<U>;
    };
    template <class U>
    void construct(U* at) noexcept {
        ::new (static_cast<void*>(at)) U;
    }
    template <class U, class... Args>
    void construct(U* at, Args&&... args) {
        ::new (static_cast<void*>(at)) U(std::forward<Args>(args)...);
    }
};

template <class T>
using Numbers = std::vector<T, Unset<T>>;

/// A name in the tree of a file's parts. Names of siblings differ.
struct Label {
    std::string name;  // UTF-8
    int parent = -1;   // index in Contents::labels, or -1
};

/// Consecutive triangles under one label.
struct Run {
    int label;  // index in Contents::labels, or -1
    std::int32_t count;
};

/// One mesh as the file stores it: indices unchecked, numbers perhaps not finite. A field is empty if the file lacks it.
struct Part {
    Numbers<double> vertices;         // (V, 3)
    Numbers<std::int32_t> triangles;  // (T, 3); -1 where the file names no vertex
    Numbers<double> normals;          // (V, 3); NaN for a vertex without a normal
    Numbers<double> colors;           // (V, 3), linear RGB; NaN is white
    Numbers<double> face_colors;      // (T, 3), linear RGB; NaN is white
    Numbers<double> alphas;           // (V, 1)
    std::vector<Numbers<double>> uv;  // each (V, 2), from the top left of the image, with all transforms applied
    int surface = -1;                 // of Contents::surfaces; -1 is plain white
    std::vector<Run> runs;            // of all triangles; empty if the file names nothing

    /// Continues the last run, or begins another.
    void add_run(int label, std::size_t count) {
        if (runs.empty() || runs.back().label != label) runs.push_back({label, 0});
        runs.back().count += static_cast<std::int32_t>(count);
    }
};

/// An image file: embedded, or next to the model.
struct Image {
    std::string name;                    // its path from the model's folder, UTF-8; empty if embedded
    std::vector<std::uint8_t> bytes = {};  // of an embedded file
    std::string label = {};                // for warnings; empty if that is its name
};

/// An image on a surface.
struct Layer {
    int image = -1;  // index in Contents::images, or -1
    Wrap across = Wrap::repeat, down = Wrap::repeat;
    int uv = 0;  // of Part::uv
};

/// How alpha is shown: not at all; where it reaches the cutoff; or as translucent, which hosts show where it reaches a half.
enum class Opacity : std::uint8_t { opaque, cutout, translucent };

struct Surface {
    std::string name;  // UTF-8
    Material material;
    Layer color, emission, metallic_roughness;  // their images have the material's factors
    Layer mask;                                 // its alpha, or red without alpha, replaces the alpha of `color`
    bool replaces_color = false;                // where `color` has an image, it replaces the colours of the material and the parts
    Opacity opacity = Opacity::opaque;
    double alpha_cutoff = 0.5;  // of the product of the image's alpha and the vertices'; infinite if nothing is shown
};

/// The upper rows of an affine map, which is multiplied from the left.
using Rows = std::array<double, 12>;

/// Straight tubes apart from each other, round at both ends.
struct Beams {
    Numbers<double> ends;   // (n, 2, 3); a ball where both are equal
    Numbers<double> radii;  // (n, 2), above 0
};

/// The surface of a formula, cut off at its bounds.
struct LevelSet {
    Expression formula;
    Bounds bounds;
    std::shared_ptr<const ColorFormula> color;  // null for white
};

/// A shape other than a mesh.
struct OtherShape {
    std::string name;  // UTF-8, empty if it has the file's
    std::array<double, 3> color{1, 1, 1};  // linear RGB
    std::variant<Beams, LevelSet> shape;
};

/// One of these in a place.
struct Placement {
    std::size_t shape;  // index in Contents::shapes
    int label;          // index in Contents::labels
    Rows place;
};

/// Everything that a file shows.
struct Contents {
    std::vector<Part> parts;
    std::vector<Label> labels;  // parents come before their children
    std::vector<Surface> surfaces;
    std::vector<Image> images;
    std::vector<OtherShape> shapes;
    std::vector<Placement> placements;  // of the shapes
    std::vector<std::string> warnings;  // a line each, without the file's name
    std::string_view unit;              // of lengths, such as "mm"; empty if the file has none
};

/// Files next to the model, which the host fetches. A reader asks for all that it wants and returns if any answer is missing;
/// the host answers, and the reader starts again.
class Beside {
public:
    struct Answer {
        std::vector<std::uint8_t> bytes;
        std::string error;  // the host's reason; empty if the file was read
    };

    /// The answer for a file, null until the host gives one. name: its path from the model's folder.
    const Answer* ask(std::string_view name) {
        static const Answer none{{}, "expected the name of a file, got none"};
        if (name.empty()) return &none;
        const auto [found, is_new] = answers_.try_emplace(std::string(name));
        if (is_new) wanted_.push_back(&*found);
        return found->second ? &*found->second : nullptr;
    }

    /// Whether a reader has to return.
    [[nodiscard]] bool is_waiting() const { return !wanted_.empty(); }
    /// The file to answer for first, while there is one.
    [[nodiscard]] const std::string& wanted() const { return wanted_.front()->first; }
    void answer(Answer answer) {
        wanted_.front()->second = std::move(answer);
        wanted_.pop_front();
    }

private:
    using Answers = std::map<std::string, std::optional<Answer>, std::less<>>;

    Answers answers_;
    std::deque<Answers::value_type*> wanted_;
};

}  // namespace bob::files
