#include "files/threemf/functions.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <stdexcept>
#include <utility>

#include "base/interruption.h"
#include "files/placing.h"
#include "files/text.h"
#include "files/threemf/nodes.h"
#include "formula/mesh_distance.h"
#include "shapes/implicit/bounds.h"

namespace bob::files::threemf {
namespace {

constexpr std::size_t max_calls = 64;  // depth of function calls

bool is_any(std::string_view name, std::initializer_list<std::string_view> names) { return std::ranges::find(names, name) != names.end(); }

/// The node and the output of a reference NODE.OUTPUT.
std::pair<std::string_view, std::string_view> parted(std::string_view reference) {
    const std::size_t point = std::min(reference.find('.'), reference.size());
    return {reference.substr(0, point), reference.substr(std::min(point + 1, reference.size()))};
}

using Known = std::map<std::string, Operands, std::less<>>;  // outputs by the names of nodes

const Operand& value_at(const Known& known, std::string_view reference) {
    const auto [node, output] = parted(reference);
    if (const auto outputs = known.find(node); outputs != known.end()) {
        for (const std::string_view name : {output, std::string_view()}) {  // of a node's only output, files have several names
            if (const auto found = outputs->second.find(name); found != outputs->second.end()) return found->second;
        }
    }
    refuse({"expected a value ", reference, ", got none"});
}

const std::string& resource(const Operands& inputs, std::string_view name) {
    const Operand& found = input(inputs, name);
    if (!found.values.empty()) refuse({name, ": expected the id of a resource, got a value"});
    return found.resource;
}

Texts texts_of(const XmlAttributes& get) {
    Texts result;
    for (const XmlAttributes::Attribute& attribute : get.all()) {
        if (attribute.space.empty()) result.emplace(attribute.name, attribute.value);
    }
    return result;
}

/// Calls f(); errors start with the function's id.
template <class F>
auto in_function(std::string_view id, F f) -> decltype(f()) {
    return at_place(joined({"function ", id}), [&] {
        try {
            return f();
        } catch (const TooLarge& error) {
            refuse({error.what()});
        }
    });
}

}  // namespace

/// Evaluates the needed nodes of functions, in a graph.
class Evaluation {
public:
    explicit Evaluation(Functions& functions) : functions_(functions) {}

    /// An output of a function at the mapped point (x, y, z).
    [[nodiscard]] Operand output(const FunctionOutput& of, std::size_t size) {
        Operand position{{graph.x(), graph.y(), graph.z()}};
        if (of.map != identity) {
            Operand map;
            for (std::size_t i = 0; i < 16; ++i) map.values.push_back(graph.constant(i < 12 ? of.map[i] : i == 15));
            position = times(map, position);
        }
        Operands found = call(of.function, {{"pos", std::move(position)}}, {of.channel});
        at_place(of.channel, [&] { check_shape(found[of.channel], size); });
        return std::move(found[of.channel]);
    }
    [[nodiscard]] Value distance(const Operand& position, std::string_view mesh) {
        check_shape(position, vector);
        return graph.substitute(functions_.distance(mesh), position.values[0], position.values[1], position.values[2]);
    }

    Graph graph;

private:
    [[nodiscard]] Operands call(const std::string& name, Operands inputs, const std::vector<std::string>& wanted) {
        const auto found = functions_.all_.find(name);
        if (found == functions_.all_.end() || !found->second) {
            refuse({"expected a function with id ", name, ", got ", found == functions_.all_.end() ? "none" : "one of an image, which is not read"});
        }
        const Function& function = *found->second;
        if (calls_.size() == max_calls || std::ranges::find(calls_, name) != calls_.end()) {
            refuse({"expected functions at most ", std::to_string(max_calls), " deep that do not call themselves, got others"});
        }
        for (const std::string& input : function.inputs) {
            if (!inputs.contains(input)) refuse({"expected a value for the input ", input, ", got none"});
        }
        calls_.push_back(name);
        Known known;
        known.emplace("inputs", std::move(inputs));
        Operands result;
        for (const std::string& output : wanted) {
            const auto reference = function.outputs.find(output);
            if (reference == function.outputs.end()) {
                std::string names;
                for (const auto& [other, of] : function.outputs) names += joined({names.empty() ? "" : ", ", other});
                refuse({"expected an output ", output, ", got ", names});
            }
            evaluate(function, reference->second, known);
            result.insert_or_assign(output, value_at(known, reference->second));
        }
        calls_.pop_back();
        return result;
    }
    /// Evaluates the node of a reference, after all nodes that it depends on.
    void evaluate(const Function& function, std::string_view reference, Known& known) {
        std::vector<std::pair<std::string_view, bool>> open = {{parted(reference).first, false}};  // a node, and whether its inputs are known
        std::set<std::string_view> being_evaluated;
        while (!open.empty()) {
            const auto [name, has_inputs] = open.back();
            open.pop_back();
            if (known.contains(name)) continue;
            const auto found = function.nodes.find(name);
            if (found == function.nodes.end()) refuse({"expected a node ", name, ", got none"});
            const FunctionNode& node = found->second;
            if (has_inputs) {
                Interruption::check();
                if (functions_.left_ == 0) refuse({"expected at most ", grouped(max_nodes), " nodes to evaluate, got more"});
                --functions_.left_;
                Operands inputs;
                for (const auto& [key, from] : node.inputs) inputs.emplace(key, value_at(known, from));
                known.emplace(name, outputs(name, node, inputs));
                being_evaluated.erase(name);
                continue;
            }
            if (!being_evaluated.insert(name).second) refuse({"expected nodes without a cycle, got one through ", name});
            open.emplace_back(name, true);
            for (const auto& [key, from] : node.inputs) open.emplace_back(parted(from).first, false);
        }
    }
    [[nodiscard]] Operands outputs(std::string_view name, const FunctionNode& node, const Operands& inputs) {
        try {
            if (node.kind == "functioncall") {
                const std::string& function = resource(inputs, "functionID");
                Operands given = inputs;
                given.erase("functionID");
                std::vector<std::string> wanted;
                if (const auto called = functions_.all_.find(function); called != functions_.all_.end() && called->second) {
                    for (const auto& [output, from] : called->second->outputs) wanted.push_back(output);
                }
                return call(function, std::move(given), wanted);
            }
            if (node.kind == "mesh" || node.kind == "unsignedmesh") {
                const Value value = distance(input(inputs, "pos"), resource(inputs, "mesh"));
                return {{"", {{node.kind == "mesh" ? value : abs(value)}}}};
            }
            return outputs_of(graph, node, inputs);
        } catch (const MissingInput& missing) {
            refuse({name, ": expected ", missing.name, ", got none"});
        }
    }

    Functions& functions_;
    std::vector<std::string> calls_;
};

void Functions::start(std::string_view name, const XmlAttributes& get) {
    const std::string identifier(get.get("identifier"));
    if (is_any(name, {"implicitfunction", "function"}) && !function_) {
        function_ = &all_.insert_or_assign(std::string(get.get("id")), Function{}).first->second.value();
    } else if (!function_ || is_any(name, {"in", "out"})) {
        return;
    } else if (is_any(name, {"scalarref", "vectorref", "matrixref", "resourceref"})) {
        const std::string_view reference = get.get("ref");
        if (reference.empty()) return;  // Gladius once wrote empty ones
        (node_ ? node_->inputs : function_->outputs).insert_or_assign(identifier, std::string(reference));
    } else if (node_) {
        return;  // its outputs, whose names follow from its kind
    } else if (is_any(name, {"scalar", "vector", "matrix", "resourceid"})) {
        function_->inputs.push_back(identifier);
    } else {
        node_ = &function_->nodes.insert_or_assign(identifier, FunctionNode{std::string(name), texts_of(get), {}}).first->second;
    }
}

void Functions::end(std::string_view name) {
    if (node_ && name == node_->kind) {
        node_ = nullptr;
    } else if (is_any(name, {"implicitfunction", "function"})) {
        function_ = nullptr;
    }
}

bool Functions::is_image(std::string_view id) const {
    const auto found = all_.find(id);
    return found != all_.end() && !found->second;
}

const Mesh& Functions::mesh(std::string_view id) const {
    const Mesh* const found = meshes_(id);
    if (!found) refuse({"expected a mesh with id ", id, ", got none"});
    return *found;
}

const Expression& Functions::distance(std::string_view id) {
    if (const auto known = distances_.find(id); known != distances_.end()) return known->second;
    const Mesh& of = mesh(id);
    std::vector<MeshDistance::Point> points(of.vertices.size() / 3);
    std::vector<MeshDistance::Triangle> triangles(of.triangles.size() / 3);
    for (std::size_t i = 0; i < of.vertices.size(); ++i) points[i / 3][i % 3] = of.vertices[i];
    for (std::size_t i = 0; i < of.triangles.size(); ++i) triangles[i / 3][i % 3] = static_cast<std::uint32_t>(of.triangles[i]);
    return distances_.emplace(id, at_place(joined({"mesh ", id}), [&] { return distance_to_mesh(points, triangles); })).first->second;
}

LevelSet Functions::level_set(const FunctionOutput& output, const Domain& domain) {
    const Mesh* const around = meshes_(domain.mesh);
    if (!around || around->vertices.empty()) refuse({"expected a mesh with id ", domain.mesh, " around it, got none"});
    Bounds box;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        box.low[axis] = box.high[axis] = around->vertices[axis];
        for (std::size_t i = axis; i < around->vertices.size(); i += 3) {
            const double x = around->vertices[i];
            if (!std::isfinite(x)) refuse({"expected a mesh of finite size around it, got another"});
            box.low[axis] = std::min(box.low[axis], x), box.high[axis] = std::max(box.high[axis], x);
        }
    }
    return in_function(output.function, [&] {
        Evaluation evaluation(*this);
        Graph& graph = evaluation.graph;
        const Operand position{{graph.x(), graph.y(), graph.z()}};
        Value value = evaluation.output(output, scalar).values[0];
        if (!domain.is_box) value = max(value, evaluation.distance(position, domain.mesh));
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double middle = (box.low[axis] + box.high[axis]) / 2, half = (box.high[axis] - box.low[axis]) / 2;
            value = max(value, abs(position.values[axis] - middle) - half);
        }
        LevelSet result{graph.expression(value), box, nullptr};
        // A domain may be far larger than its shape, and cells are fractions of the bounds.
        try {
            result.bounds = find_bounds(result.formula).value_or(box);
        } catch (const std::invalid_argument&) {
        }
        for (std::size_t axis = 0; axis < 3; ++axis) {
            if (!(result.bounds.low[axis] < result.bounds.high[axis])) refuse({"expected a mesh around it that is not flat, got another"});
        }
        return result;
    });
}

ColorFormula Functions::color(const FunctionOutput& output) {
    return in_function(output.function, [&] {
        Evaluation evaluation(*this);
        const std::vector<Value> rgb = evaluation.output(output, vector).values;
        return evaluation.graph.color_formula({rgb[0], rgb[1], rgb[2]});
    });
}

}  // namespace bob::files::threemf
