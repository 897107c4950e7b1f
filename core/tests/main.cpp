#include <cstdio>
#include <set>

#include "check.h"

namespace test {
namespace {

const char* running = "";
std::set<std::string> failed;
int messages = 0;

}  // namespace

std::vector<Case>& cases() {
    static std::vector<Case> all;
    return all;
}

void fail(const char* file, int line, const std::string& what) {
    failed.insert(running);
    if (++messages <= 20) std::fprintf(stderr, "%s:%d: %s: %s\n", file, line, running, what.c_str());
}

}  // namespace test

int main() {
    for (const auto& [name, run] : test::cases()) {
        test::running = name;
        run();
    }
    const std::size_t count = test::cases().size(), failures = test::failed.size();
    std::printf("core: %zu passed, %zu failed\n", count - failures, failures);
    return failures || !count;
}
