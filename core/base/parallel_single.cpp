/// parallel.h without threads, as in a WebAssembly module without shared memory: a page starts several workers instead.
#include <algorithm>

#include "base/interruption.h"
#include "base/parallel.h"

namespace bob {

int thread_count() { return 1; }

void set_thread_count(int) {}

void parallel_for(std::size_t count, std::size_t grain, const std::function<void(std::size_t, std::size_t)>& body) {
    grain = std::max<std::size_t>(1, grain);
    for (std::size_t begin = 0; begin < count; begin += std::min(grain, count - begin)) {
        Interruption::check();
        body(begin, std::min(begin + grain, count));
    }
}

}  // namespace bob
