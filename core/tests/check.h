/// A test is a function that CHECKs; the runner in main.cpp calls them all.
#pragma once

#include <cmath>
#include <functional>
#include <sstream>
#include <string>
#include <vector>

#include "base/isa.h"

namespace test {

struct Case {
    const char* name;
    std::function<void()> run;
};

std::vector<Case>& cases();
void fail(const char* file, int line, const std::string& what);

struct Register {
    Register(const char* name, void (*run)()) { cases().push_back({name, run}); }
};

/// Calls body once with each instruction set of this machine in use.
template <class Body>
void for_each_isa(Body body) {
    const bob::Isa best = bob::isa();
    for (const bob::Isa isa : {bob::Isa::baseline, bob::Isa::avx2, bob::Isa::avx512}) {
        if (bob::set_isa(isa)) body();
    }
    bob::set_isa(best);
}

/// Numbers in 0..1, the same on every machine.
class Random {
public:
    explicit Random(std::uint64_t seed) : state_(seed * 0x9e3779b97f4a7c15 + 1) {}
    float operator()() {
        state_ ^= state_ << 13, state_ ^= state_ >> 7, state_ ^= state_ << 17;
        return static_cast<float>(state_ >> 40) * 0x1p-24f;
    }
    float operator()(float low, float high) { return low + (high - low) * (*this)(); }

private:
    std::uint64_t state_;
};

/// A comparison, in words. (Not in the macro below, where each check would compile it.)
template <class A, class B>
std::string told(const char* comparison, const A& a, const B& b) {
    std::ostringstream text;
    text << comparison << ": " << +a << " and " << +b << ", " << name(bob::isa());
    return text.str();
}

}  // namespace test

#define TEST(name)                                              \
    static void name();                                         \
    static const test::Register register_##name{#name, name};   \
    static void name()

#define CHECK_COMPARE(a, op, b)                                                                 \
    do {                                                                                        \
        const auto va = (a);                                                                    \
        const auto vb = (b);                                                                    \
        if (!(va op vb)) test::fail(__FILE__, __LINE__, test::told(#a " " #op " " #b, va, vb)); \
    } while (false)

#define CHECK_EQ(a, b) CHECK_COMPARE(a, ==, b)
#define CHECK_LT(a, b) CHECK_COMPARE(a, <, b)
#define CHECK_NEAR(a, b, tolerance) CHECK_LT(std::fabs((a) - (b)), tolerance)
#define CHECK(condition) CHECK_EQ(static_cast<bool>(condition), true)
