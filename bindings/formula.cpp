/// Formulas: graphs that record Python functions, and the resulting expressions.
#include <nanobind/nanobind.h>
#include <nanobind/operators.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>
#include <nanobind/stl/tuple.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/parallel.h"
#include "bindings.h"
#include "formula/arrays.h"
#include "formula/expression.h"
#include "formula/mesh_distance.h"
#include "formula/text.h"

using namespace nb::literals;

namespace {

bob::Op find_op(std::string_view name) {
    for (int i = 0; i < bob::op_count; ++i) {
        if (bob::name(static_cast<bob::Op>(i)) == name) return static_cast<bob::Op>(i);
    }
    throw nb::value_error(("op: expected the name of an operation, got '" + std::string(name) + "'").c_str());
}

bob::Op find_op(std::string_view name, int operands) {
    const bob::Op op = find_op(name);
    expect(bob::operands(op) == operands, "op: expected one with another number of operands");
    return op;
}

/// A graph whose values are plain integers in Python, so that tracing allocates nothing. The upper half is the graph's
/// number, which distinguishes values of different graphs; the lower half is the node's index.
class Graph {
public:
    using Handle = std::uint64_t;

    Handle x() { return handle(graph_.x()); }
    Handle y() { return handle(graph_.y()); }
    Handle z() { return handle(graph_.z()); }
    Handle constant(double value) { return handle(graph_.constant(value)); }
    Handle unary(std::string_view name, Handle a, int exponent) {
        return handle(graph_.unary(find_op(name, 1), value(a), exponent));
    }
    Handle binary(std::string_view name, Handle a, Handle b) {
        return handle(graph_.binary(find_op(name, 2), value(a), value(b)));
    }
    Handle select(Handle a, Handle b, Handle c) { return handle(graph_.select(value(a), value(b), value(c))); }
    Handle piecewise(Handle a, Handle b, Handle c) { return handle(graph_.piecewise(value(a), value(b), value(c))); }
    Handle substitute(const bob::Expression& f, Handle x, Handle y, Handle z) {
        return handle(graph_.substitute(f, value(x), value(y), value(z)));
    }
    std::tuple<Handle, Handle, Handle> substitute_color(const bob::ColorFormula& f, Handle x, Handle y, Handle z) {
        const auto rgb = graph_.substitute(f, value(x), value(y), value(z));
        return {handle(rgb[0]), handle(rgb[1]), handle(rgb[2])};
    }
    [[nodiscard]] bob::Expression expression(Handle root) { return graph_.expression(value(root)); }
    [[nodiscard]] bob::ColorFormula color_formula(Handle r, Handle g, Handle b) {
        return graph_.color_formula({value(r), value(g), value(b)});
    }
    [[nodiscard]] std::size_t size() const { return graph_.size(); }

private:
    [[nodiscard]] Handle handle(bob::Value value) const { return (Handle{number_} << 32) | value.index; }

    [[nodiscard]] bob::Value value(Handle handle) {
        const auto index = static_cast<std::uint32_t>(handle);
        expect(handle >> 32 == number_ && index < graph_.size(), "expected a value of this graph");
        return {&graph_, index};
    }

    static inline std::atomic<std::uint32_t> graphs = 0;
    std::uint32_t number_ = ++graphs;
    bob::Graph graph_;
};

using Ops = Array<std::uint8_t, -1>;
using Operands = Array<std::uint32_t, -1, 3>;
using Values = Array<double, -1>;
using Roots = Array<std::uint32_t, 3>;

/// (m, 2), (v, 3) and (t, 3), as in bob::MeshArrays.
using MeshSizes = Array<const std::uint32_t, -1, 2>;
using MeshVertices = Array<const float, -1, 3>;
using MeshTriangles = Array<const std::uint32_t, -1, 3>;

template <class A>
auto span_of(const A& array) {
    return std::span(array.data(), array.size());
}

bob::Meshes meshes_of(const std::optional<MeshSizes>& sizes, const std::optional<MeshVertices>& vertices,
                      const std::optional<MeshTriangles>& triangles) {
    expect(sizes.has_value() == vertices.has_value() && sizes.has_value() == triangles.has_value(),
           "expected the sizes, vertices and triangles of meshes together");
    bob::Meshes meshes;
    if (sizes) interruptible([&] { meshes = bob::meshes_of({span_of(*sizes), span_of(*vertices), span_of(*triangles)}); });
    return meshes;
}

std::vector<bob::Node> nodes_of(const Array<const std::uint8_t, -1>& ops, const Array<const std::uint32_t, -1, 3>& operands,
                                const Array<const double, -1>& values, const bob::Meshes& meshes) {
    const std::size_t count = ops.shape(0);
    expect(operands.shape(0) == count && values.shape(0) == count, "expected ops, operands and values of one length");
    return bob::nodes_of(ops.data(), operands.data(), values.data(), count, meshes);
}

void init_expression(bob::Expression* self, const Array<const std::uint8_t, -1>& ops,
                     const Array<const std::uint32_t, -1, 3>& operands, const Array<const double, -1>& values,
                     const std::optional<MeshSizes>& mesh_sizes, const std::optional<MeshVertices>& mesh_vertices,
                     const std::optional<MeshTriangles>& mesh_triangles) {
    const bob::Meshes meshes = meshes_of(mesh_sizes, mesh_vertices, mesh_triangles);
    new (self) bob::Expression(nodes_of(ops, operands, values, meshes));
}

void init_color_formula(bob::ColorFormula* self, const Array<const std::uint8_t, -1>& ops,
                        const Array<const std::uint32_t, -1, 3>& operands, const Array<const double, -1>& values,
                        const Array<const std::uint32_t, 3>& roots, const std::optional<MeshSizes>& mesh_sizes,
                        const std::optional<MeshVertices>& mesh_vertices, const std::optional<MeshTriangles>& mesh_triangles) {
    const bob::Meshes meshes = meshes_of(mesh_sizes, mesh_vertices, mesh_triangles);
    new (self) bob::ColorFormula(nodes_of(ops, operands, values, meshes), {roots.data()[0], roots.data()[1], roots.data()[2]});
}

template <class Formula>
AnyTuple mesh_arrays(const Formula& formula) {
    const bob::Meshes& meshes = formula.meshes();
    if (meshes.empty()) return nb::make_tuple();
    std::size_t vertices = 0, triangles = 0;
    for (const auto& mesh : meshes) vertices += mesh->vertices().size(), triangles += mesh->triangles().size();
    auto sizes = make_array<std::uint32_t, -1, 2>(meshes.size(), 2);
    auto points = make_array<float, -1, 3>(vertices, 3);
    auto corners = make_array<std::uint32_t, -1, 3>(triangles, 3);
    std::uint32_t* size = sizes.data();
    float* point = points.data();
    std::uint32_t* corner = corners.data();
    for (const auto& mesh : meshes) {
        *size++ = static_cast<std::uint32_t>(mesh->vertices().size());
        *size++ = static_cast<std::uint32_t>(mesh->triangles().size());
        for (const bob::Vec3& v : mesh->vertices()) *point++ = v.x, *point++ = v.y, *point++ = v.z;
        for (const bob::MeshDistance::Triangle& t : mesh->triangles()) corner = std::ranges::copy(t, corner).out;
    }
    return nb::make_tuple(nb::cast(std::move(sizes)), nb::cast(std::move(points)), nb::cast(std::move(corners)));
}

bob::Expression distance_to_mesh(const Array<const double, -1, 3>& vertices, const Array<const std::int32_t, -1, 3>& triangles) {
    std::vector<bob::MeshDistance::Point> points(vertices.shape(0));
    std::vector<bob::MeshDistance::Triangle> corners(triangles.shape(0));
    std::copy_n(vertices.data(), 3 * points.size(), points.empty() ? nullptr : points[0].data());
    std::copy_n(triangles.data(), 3 * corners.size(), corners.empty() ? nullptr : corners[0].data());
    std::optional<bob::Expression> result;
    interruptible([&] { result = bob::distance_to_mesh(points, corners); });
    return *result;
}

template <class Formula>
Ops ops(const Formula& formula) {
    const auto& nodes = formula.nodes();
    auto result = make_array<std::uint8_t, -1>(nodes.size());
    for (std::size_t i = 0; i < nodes.size(); ++i) result.data()[i] = static_cast<std::uint8_t>(nodes[i].op);
    return result;
}

template <class Formula>
Operands operands(const Formula& formula) {
    const auto& nodes = formula.nodes();
    auto result = make_array<std::uint32_t, -1, 3>(nodes.size(), 3);
    for (std::size_t i = 0; i < nodes.size(); ++i) std::copy_n(nodes[i].operand, 3, result.data() + 3 * i);
    return result;
}

template <class Formula>
Values values(const Formula& formula) {
    const auto& nodes = formula.nodes();
    auto result = make_array<double, -1>(nodes.size());
    for (std::size_t i = 0; i < nodes.size(); ++i) result.data()[i] = bob::value_in_arrays(nodes[i], formula.meshes());
    return result;
}

Roots roots(const bob::ColorFormula& formula) {
    auto result = make_array<std::uint32_t, 3>(3);
    std::copy_n(formula.roots().data(), 3, result.data());
    return result;
}

Values evaluate(const bob::Expression& f, const Array<const double, -1, 3>& points) {
    auto result = make_array<double, -1>(points.shape(0));
    interruptible([&] {
        bob::parallel_for(points.shape(0), 64, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const double* p = points.data() + 3 * i;
                result.data()[i] = f(p[0], p[1], p[2]);
            }
        });
    });
    return result;
}

Array<double, -1, 3> evaluate_colors(const bob::ColorFormula& f, const Array<const double, -1, 3>& points) {
    auto result = make_array<double, -1, 3>(points.shape(0), 3);
    interruptible([&] {
        bob::parallel_for(points.shape(0), 64, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const double* p = points.data() + 3 * i;
                std::ranges::copy(f(p[0], p[1], p[2]), result.data() + 3 * i);
            }
        });
    });
    return result;
}

std::size_t mixed(std::size_t h, std::size_t part) { return (h ^ part) * 0x9e3779b97f4a7c15 + 1; }

template <class Formula>
std::size_t hash(const Formula& formula) {
    std::size_t h = formula.nodes().size();
    for (const bob::Node& node : formula.nodes()) {
        h = mixed(h, static_cast<std::size_t>(node.op));
        for (const std::uint32_t operand : node.operand) h = mixed(h, operand);
        h = mixed(h, std::hash<double>{}(node.value));
    }
    return h;
}

}  // namespace

void bind_formula(nb::module_& m) {
    nb::exception<bob::TooLarge>(m, "TooLargeError", PyExc_ValueError);

    nb::class_<bob::Expression>(m, "Expression",
        "A formula f(x, y, z), immutable; equal if its nodes are.\n\n"
        "Node i has the number of an op, ops[i]; up to three earlier nodes, operands[i]; and a constant's value, a power's exponent, the "
        "place of a mesh, or 1 of a select at which the formula does not jump, values[i]. The last node is the result. Meshes are there "
        "one after the other: `mesh_sizes` (m, 2), how many vertices and triangles each has, `mesh_vertices` (v, 3), -1..1, and "
        "`mesh_triangles` (t, 3). ValueError if they are no formula.")
        .def("__init__", &init_expression, "ops"_a.noconvert(), "operands"_a.noconvert(), "values"_a.noconvert(),
             "mesh_sizes"_a.noconvert() = nb::none(), "mesh_vertices"_a.noconvert() = nb::none(),
             "mesh_triangles"_a.noconvert() = nb::none())
        .def_prop_ro("ops", &ops<bob::Expression>, nb::rv_policy::move)
        .def_prop_ro("operands", &operands<bob::Expression>, nb::rv_policy::move)
        .def_prop_ro("values", &values<bob::Expression>, nb::rv_policy::move)
        .def_prop_ro("mesh_arrays", &mesh_arrays<bob::Expression>, "Its meshes as the constructor takes them; empty if it has none.")
        .def("uses", [](const bob::Expression& f, std::string_view op) { return f.uses(find_op(op)); }, "op"_a)
        .def("__call__", &evaluate, "points"_a.noconvert(), "The values at points (n, 3), in double precision.")
        .def("__len__", [](const bob::Expression& f) { return f.nodes().size(); })
        .def(nb::self == nb::self, nb::sig("def __eq__(self, arg: object, /) -> bool"))
        .def("__hash__", &hash<bob::Expression>)
        .def("__str__", [](const bob::Expression& f) { return bob::to_text(f); })
        .def("__repr__", [](const bob::Expression& f) { return "<Expression " + bob::to_text(f, 60) + ">"; })
        .def("__reduce__", [](nb::handle self) -> AnyTuple {
            const auto& f = nb::cast<const bob::Expression&>(self);
            return nb::make_tuple(self.type(), nb::make_tuple(ops(f), operands(f), values(f)) + mesh_arrays(f));
        });

    m.def("distance_to_mesh", &distance_to_mesh, "vertices"_a.noconvert(), "triangles"_a.noconvert(),
          "The signed distance from a mesh, (v, 3) and (t, 3); ValueError unless it is closed.");

    nb::class_<bob::ColorFormula>(m, "ColorFormula",
        "A colour (r, g, b)(x, y, z), linear RGB, immutable; equal if its nodes and roots are.\n\n"
        "Nodes are as of an Expression; red, green and blue are the nodes `roots`. ValueError if they are no formula.")
        .def("__init__", &init_color_formula, "ops"_a.noconvert(), "operands"_a.noconvert(), "values"_a.noconvert(),
             "roots"_a.noconvert(), "mesh_sizes"_a.noconvert() = nb::none(), "mesh_vertices"_a.noconvert() = nb::none(),
             "mesh_triangles"_a.noconvert() = nb::none())
        .def_static("constant", [](double r, double g, double b) { return bob::ColorFormula({r, g, b}); }, "r"_a, "g"_a, "b"_a)
        .def_prop_ro("ops", &ops<bob::ColorFormula>, nb::rv_policy::move)
        .def_prop_ro("operands", &operands<bob::ColorFormula>, nb::rv_policy::move)
        .def_prop_ro("values", &values<bob::ColorFormula>, nb::rv_policy::move)
        .def_prop_ro("roots", &roots, nb::rv_policy::move)
        .def_prop_ro("mesh_arrays", &mesh_arrays<bob::ColorFormula>)
        .def("__call__", &evaluate_colors, "points"_a.noconvert(),
             "The colours (n, 3), clamped to 0..1, at points (n, 3), in double precision.")
        .def("__len__", [](const bob::ColorFormula& f) { return f.nodes().size(); })
        .def(nb::self == nb::self, nb::sig("def __eq__(self, arg: object, /) -> bool"))
        .def("__hash__", [](const bob::ColorFormula& f) {
            std::size_t h = hash(f);
            for (const std::uint32_t root : f.roots()) h = mixed(h, root);
            return h;
        })
        .def("__repr__", [](const bob::ColorFormula& f) {
            return "<ColorFormula of " + std::to_string(f.nodes().size()) + " steps>";
        })
        .def("__reduce__", [](nb::handle self) -> AnyTuple {
            const auto& f = nb::cast<const bob::ColorFormula&>(self);
            return nb::make_tuple(self.type(), nb::make_tuple(ops(f), operands(f), values(f), roots(f)) + mesh_arrays(f));
        });

    nb::class_<Graph>(m, "Graph", "Builds expressions. Its values are integers; those of another graph are refused with a ValueError.")
        .def(nb::init<>())
        .def("x", &Graph::x)
        .def("y", &Graph::y)
        .def("z", &Graph::z)
        .def("constant", &Graph::constant, "value"_a)
        .def("unary", &Graph::unary, "op"_a, "a"_a, "exponent"_a = 0)
        .def("binary", &Graph::binary, "op"_a, "a"_a, "b"_a)
        .def("select", &Graph::select, "a"_a, "b"_a, "c"_a, "b where a < 0, else c.")
        .def("piecewise", &Graph::piecewise, "a"_a, "b"_a, "c"_a, "The same where b and c meet.")
        .def("substitute", &Graph::substitute, "f"_a, "x"_a, "y"_a, "z"_a)
        .def("substitute_color", &Graph::substitute_color, "f"_a, "x"_a, "y"_a, "z"_a)
        .def("expression", &Graph::expression, "root"_a)
        .def("color_formula", &Graph::color_formula, "r"_a, "g"_a, "b"_a)
        .def("__len__", &Graph::size);
}
