/// Data compressed by Draco and meshopt: any bytes end in arrays of the right sizes, or an error.
#include <stdexcept>
#include <string_view>

#include "base/interruption.h"
#include "files/draco/mesh.h"
#include "files/meshopt.h"
#include "fuzz/fuzz.h"

namespace {

void unpack_draco(bob::files::Bytes bytes) {
    bob::files::Budget budget(1 << 26);
    const bob::files::DracoMesh mesh = bob::files::draco_decoded(bytes, 1 << 20, budget);
    fuzz::expect(mesh.triangles.size() % 3 == 0 && mesh.triangles.size() <= 3 << 20, "no more triangles than allowed");
    for (const auto& attribute : mesh.attributes) {
        fuzz::expect(attribute.width > 0 && attribute.values.size() == mesh.points * attribute.width, "values for each point");
    }
}

}  // namespace

/// A byte for the kind; of meshopt, then the count in two bytes, a byte for the stride and one for the filter.
FUZZ(compressed) {
    constexpr std::string_view modes[] = {"ATTRIBUTES", "TRIANGLES", "INDICES"};
    constexpr std::string_view filters[] = {"NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL", "COLOR"};
    try {
        const bob::Interruption impatience(fuzz::Patience{1000});
        const std::uint32_t kind = source.below(4);
        if (kind == 3) return unpack_draco(source.rest());
        const std::size_t count = source.raw<std::uint16_t>(), stride = source.byte();
        const std::string_view filter = filters[source.below(5)];
        fuzz::expect(bob::files::meshopt_decoded(source.rest(), count, stride, modes[kind], filter).size() == count * stride, "the bytes of all elements");
    } catch (const std::invalid_argument&) {
    } catch (const bob::Stopped&) {
    }
}
