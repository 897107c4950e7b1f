/// parallel.h where there are no threads, as in a WebAssembly module: a page starts several workers instead.
#include <algorithm>

#include "parallel.h"

namespace bob {

int thread_count() { return 1; }

void set_thread_count(int) {}

bool parallel_for(std::size_t count, std::size_t grain, const std::function<void(std::size_t, std::size_t)>& body,
                  const std::function<bool()>& keep_going) {
    grain = std::max<std::size_t>(1, grain);
    for (std::size_t begin = 0; begin < count; begin += std::min(grain, count - begin)) {
        body(begin, std::min(begin + grain, count));
        if (keep_going && !keep_going()) return false;
    }
    return true;
}

}  // namespace bob
