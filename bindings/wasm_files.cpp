/// Files of meshes in the WebAssembly modules; core.wasm omits them.
#include "wasm.h"
#include "wasm_reading.h"

/// The bytes have to stay until the reading is freed.
EXPORT(make_reading)
Reading* make_reading(const char* format, std::size_t length, const std::uint8_t* bytes, std::size_t size) {
    return attempt([&] { return new Reading{bob::files::Reading(bob::files::reader_of_meshes({format, length}), {bytes, size})}; });
}
