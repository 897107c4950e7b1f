/// Functions of a 3MF, after its Volumetric and Implicit Extensions 1.0: graphs of nodes, as formulas.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "files/threemf/palette.h"
#include "files/xml.h"
#include "formula/expression.h"

namespace bob::files::threemf {

/// Nodes evaluated for all level sets and colours of a model: a chain of functions that each call two can make 2^n.
constexpr std::size_t max_nodes = 1 << 16;

using Texts = std::map<std::string, std::string, std::less<>>;

/// A node of a function.
struct FunctionNode {
    std::string kind;
    Texts get;     // its attributes
    Texts inputs;  // references NODE.OUTPUT, by the names of inputs
};

struct Function {
    std::vector<std::string> inputs;
    std::map<std::string, FunctionNode, std::less<>> nodes;
    Texts outputs;  // references NODE.OUTPUT, by the names of outputs
};

/// A level set or a colour: an output of a function, whose points are mapped before.
struct FunctionOutput {
    std::string function, channel;
    Rows map;
};

/// Where a level set is: within a mesh, or its box.
struct Domain {
    std::string mesh;
    bool is_box;
};

/// The functions of a model by id, filled element by element; null for functions of images.
class Functions {
public:
    /// meshes: the mesh of an object by its id, or null.
    explicit Functions(std::function<const Mesh*(std::string_view)> meshes) : meshes_(std::move(meshes)) {}

    /// An element of the Implicit Extension starts or ends.
    void start(std::string_view name, const XmlAttributes& get);
    void end(std::string_view name);

    void add_image(std::string_view id) { all_.insert_or_assign(std::string(id), std::nullopt); }
    [[nodiscard]] bool is_image(std::string_view id) const;

    /// The zero surface of a scalar output. Throws std::invalid_argument, of one line, where there is none.
    [[nodiscard]] LevelSet level_set(const FunctionOutput& output, const Domain& domain);
    /// The formula of a vector output, linear RGB.
    [[nodiscard]] ColorFormula color(const FunctionOutput& output);

private:
    friend class Evaluation;

    [[nodiscard]] const Mesh& mesh(std::string_view id) const;
    /// The signed distance from a mesh.
    [[nodiscard]] const Expression& distance(std::string_view mesh);

    std::function<const Mesh*(std::string_view)> meshes_;
    std::map<std::string, std::optional<Function>, std::less<>> all_;
    std::map<std::string, Expression, std::less<>> distances_;  // by the ids of meshes
    Function* function_ = nullptr;                              // that takes nodes, and the node that takes inputs
    FunctionNode* node_ = nullptr;
    std::size_t left_ = max_nodes;
};

}  // namespace bob::files::threemf
