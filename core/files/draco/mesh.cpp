#include "files/draco/mesh.h"

#include <algorithm>
#include <deque>
#include <limits>
#include <utility>

#include "files/draco/attributes.h"
#include "files/draco/connectivity.h"
#include "files/draco/entropy.h"
#include "files/draco/predictions.h"
#include "files/text.h"

namespace bob::files {
namespace {

using namespace draco;

/// Skips entries and the entries within them.
void skip_metadata(Stream& stream) {
    const auto skip_name = [&] { static_cast<void>(stream.take(stream.number())); };
    const auto skip_entries = [&] {
        for (std::uint32_t left = stream.varint(); left > 0; --left) {
            skip_name();
            static_cast<void>(stream.take(stream.varint()));
        }
        return std::uint64_t{stream.varint()};
    };
    const auto skip_tree = [&] {
        for (std::uint64_t left = skip_entries(); left > 0; --left) {
            skip_name();
            left += skip_entries();
        }
    };
    for (std::uint32_t left = stream.varint(); left > 0; --left) {
        static_cast<void>(stream.varint());
        skip_tree();
    }
    skip_tree();
}

/// Triangles in their order, by differences of their corners or plainly.
Connectivity sequential(Stream& stream, std::size_t max_triangles, Budget& budget) {
    const std::uint32_t triangles = stream.varint(), points = stream.varint();
    if (triangles > max_triangles || triangles > stream.size() / 3) {
        refuse({"expected at most ", grouped(std::min(max_triangles, stream.size() / 3)), " triangles, got ", grouped(triangles)});
    }
    if (points > std::numeric_limits<std::int32_t>::max()) refuse({"expected fewer points, got ", grouped(points)});
    Connectivity result;
    result.point_count = points;
    result.points.resize(std::size_t{3} * triangles);
    if (stream.number() == 0) {
        std::uint32_t last = 0;
        const std::vector<std::uint32_t> differences = symbols(stream, result.points.size(), 1, budget);
        for (std::size_t i = 0; i < differences.size(); ++i) {
            last += differences[i] & 1 ? 0 - (differences[i] >> 1) : differences[i] >> 1;
            result.points[i] = static_cast<std::int32_t>(last);
        }
    } else {
        for (std::int32_t& point : result.points) {
            const std::uint32_t number = points < 256         ? stream.number()
                                         : points < (1 << 16) ? stream.number<std::uint16_t>()
                                         : points < (1 << 21) ? stream.varint()
                                                              : stream.number<std::uint32_t>();
            point = static_cast<std::int32_t>(number);
        }
    }
    return result;
}

/// Attributes whose values have one order.
struct Group {
    const Sequence* sequence;
    std::vector<draco::Attribute> attributes;
};

/// The orders of values, by the groups that have them.
std::deque<Sequence> sequences_of(Stream& stream, const Connectivity& mesh, bool is_sequential, std::size_t groups, Budget& budget) {
    std::deque<Sequence> result;
    for (std::size_t i = 0; i < groups; ++i) {
        if (is_sequential) {
            result.emplace_back().count = mesh.point_count;
            continue;
        }
        const int number = stream.number<std::int8_t>();
        const bool is_cut = stream.number() != 0, is_by_degree = stream.number() == 1;
        if (number >= static_cast<int>(mesh.cut.size()) || (is_cut && (number < 0 || is_by_degree))) {
            refuse({"expected attributes of known triangles, got others"});
        }
        const Corners& corners = is_cut ? mesh.cut[static_cast<std::size_t>(number)] : mesh.corners;
        budget.take(8 * std::uint64_t{corners.leftmost.size()} + corners.vertex.size());
        result.push_back(walk(corners, is_by_degree));
    }
    return result;
}

/// The numbers of each point.
Numbers<double> values_of_points(const draco::Attribute& attribute, const Sequence& sequence, const Connectivity& mesh, Budget& budget) {
    budget.take(8 * std::uint64_t{mesh.point_count} * attribute.width);
    Numbers<double> result(attribute.values.begin(), attribute.values.end());
    if (!sequence.corners) return result;
    result.assign(mesh.point_count * attribute.width, 0);
    for (std::size_t c = 0; c < mesh.points.size(); ++c) {
        const std::size_t value = sequence.at_corner(static_cast<std::int32_t>(c));
        std::copy_n(attribute.values.begin() + static_cast<std::ptrdiff_t>(value * attribute.width), attribute.width,
                    result.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(mesh.points[c]) * attribute.width));
    }
    return result;
}

}  // namespace

DracoMesh draco_decoded(Bytes bytes, std::size_t max_triangles, Budget& budget) {
    constexpr int components[] = {5120, 5121, 5122, 5123, 5125, 5125};
    constexpr std::uint16_t has_metadata = 0x8000;
    Stream stream(bytes);
    const Bytes magic = stream.take(5);
    const int major = stream.number(), minor = stream.number();
    if (std::string_view(reinterpret_cast<const char*>(magic.data()), magic.size()) != "DRACO" || major != 2 || minor != 2) {
        refuse({"expected Draco of version 2.2, got another version or something else"});
    }
    const bool is_mesh = stream.number() == 1;
    const std::uint8_t method = stream.number();
    if (!is_mesh || method > 1) refuse({"expected a mesh of triangles, got another kind"});
    if (stream.number<std::uint16_t>() & has_metadata) skip_metadata(stream);
    const bool is_sequential = method == 0;
    const Connectivity mesh = is_sequential ? sequential(stream, max_triangles, budget) : edgebreaker(stream, max_triangles, budget);

    const std::uint8_t count = stream.number();
    const std::deque<Sequence> sequences = sequences_of(stream, mesh, is_sequential, count, budget);
    std::vector<Group> groups;
    for (std::size_t i = 0; i < count; ++i) groups.push_back({&sequences[i], read_descriptions(stream)});
    Positions positions;
    DracoMesh result;
    result.points = mesh.point_count;
    for (Group& group : groups) {
        for (draco::Attribute& attribute : group.attributes) {
            read_stored(stream, attribute, *group.sequence, positions, budget);
            if (attribute.kind == 0 && !positions.attribute) positions = {group.sequence, &attribute};
        }
        for (draco::Attribute& attribute : group.attributes) {
            read_values(stream, attribute);
            result.attributes.push_back({attribute.id, attribute.type <= 6 ? components[attribute.type - 1] : 5126, attribute.width,
                                         values_of_points(attribute, *group.sequence, mesh, budget)});
        }
    }
    result.triangles.assign(mesh.points.begin(), mesh.points.end());
    return result;
}

}  // namespace bob::files
