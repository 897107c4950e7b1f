/// Work budgets, so that no file, however odd, builds for minutes.
///
/// Work is counted, never timed: every machine and every number of threads makes the same shape. A unit is about a
/// nanosecond of one core, so that a budget reads as a time.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/interruption.h"
#include "base/parallel.h"

namespace bob {

class Work {
public:
    explicit Work(std::uint64_t budget = 0) : budget_(budget) {}

    /// Counts units; the work can be interrupted here.
    void spend(std::uint64_t units) {
        Interruption::check();
        spent_ += units;
    }
    [[nodiscard]] bool is_spent() const { return spent_ >= budget_; }
    [[nodiscard]] std::uint64_t spent() const { return spent_; }

    /// Grants units beyond those spent.
    void grant(std::uint64_t units) { budget_ = spent_ + units; }

private:
    std::uint64_t budget_, spent_ = 0;
};

/// Runs resumable parts of a job on all threads, within one budget. Returns whether all are done.
///
/// Small parts leave units for large ones: in each turn, half of the remaining units is shared evenly among the
/// unfinished parts. Each part has go_on(units), which works until it is done or has spent about that number; work();
/// and is_done().
template <class Part>
bool do_in_turns(std::vector<Part>& parts, std::uint64_t budget) {
    while (true) {
        std::vector<Part*> open;
        std::uint64_t spent = 0;
        for (Part& part : parts) {
            spent += part.work().spent();
            if (!part.is_done()) open.push_back(&part);
        }
        if (open.empty()) return true;
        const std::uint64_t left = budget - std::min(spent, budget);
        if (left < budget / 64) return false;
        const std::uint64_t share = std::max<std::uint64_t>(1, left / 2 / open.size());
        parallel_for(open.size(), 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) open[i]->go_on(share);
        });
    }
}

}  // namespace bob
