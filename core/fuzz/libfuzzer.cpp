/// The one target that is linked with it, as libFuzzer calls it.
#include <cstdio>
#include <cstdlib>

#include "fuzz/fuzz.h"

namespace {

void (*target)(fuzz::Source) = nullptr;

}  // namespace

fuzz::Register::Register(const char*, void (*run)(Source)) { target = run; }

/// Short allocation stacks save a fifth of the time; errors still have full stacks. The quarantine of freed memory holds one input's
/// worth, since the default of 256 MB exceeds the cache. Each exception scans the stack of frames that have returned: at 64 KiB of
/// them instead of 1 MiB, refused files take half the time.
extern "C" const char* __asan_default_options() {
    return "malloc_context_size=2:quarantine_size_mb=8:thread_local_quarantine_size_kb=64:max_uar_stack_size_log=16";
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    try {
        target(fuzz::Source({data, size}));
    } catch (const fuzz::Broken& broken) {
        std::fprintf(stderr, "expected: %s\n", broken.what);
        std::abort();
    }
    return 0;  // any other exception is a crash
}
