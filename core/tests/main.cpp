#include <algorithm>
#include <cstdio>
#include <set>
#include <span>
#include <string>
#include <string_view>

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

/// core_tests [K/N] [NAME...]: runs the tests whose names contain any of these, by default all; of every N tests the K-th.
int main(int count, char** arguments) {
    std::span<char*> wanted(arguments + 1, arguments + count);
    std::size_t part = 0, parts = 1, at = 0, ran = 0;
    if (!wanted.empty() && std::sscanf(wanted[0], "%zu/%zu", &part, &parts) == 2 && parts > 0) wanted = wanted.subspan(1);
    for (const auto& [name, run] : test::cases()) {
        if (++at % parts != part % parts) continue;
        const bool is_wanted = std::ranges::any_of(wanted, [name = std::string_view(name)](const char* part) {
            return name.find(part) != std::string_view::npos;
        });
        if (!wanted.empty() && !is_wanted) continue;
        test::running = name;
        run();
        ++ran;
    }
    const std::size_t failures = test::failed.size();
    std::printf("core: %zu passed, %zu failed\n", ran - failures, failures);
    return failures || !ran;
}
