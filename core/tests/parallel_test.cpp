#include "base/parallel.h"

#ifndef _WIN32
#include <sys/wait.h>
#include <unistd.h>
#endif

#include <algorithm>
#include <atomic>
#include <mutex>
#include <numeric>
#include <stdexcept>
#include <thread>
#include <vector>

#include "base/mutex.h"
#include "check.h"
#include "interrupted.h"

namespace {

/// Runs body with four threads, however many the machine has.
template <class Body>
void with_threads(Body body) {
    const int threads = bob::thread_count();
    bob::set_thread_count(4);
    body();
    bob::set_thread_count(threads);
}

}  // namespace

TEST(parallel_for_covers_every_index_once) {
    with_threads([] {
        for (const std::size_t count : {0, 1, 7, 1000}) {
            std::vector<int> visits(count, 0);
            bob::parallel_for(count, 3, [&](std::size_t begin, std::size_t end) {
                for (std::size_t i = begin; i < end; ++i) ++visits[i];
            });
            CHECK_EQ(static_cast<std::size_t>(std::count(visits.begin(), visits.end(), 1)), count);
        }
    });
}

TEST(parallel_for_inside_parallel_for) {
    with_threads([] {
        std::atomic<int> sum = 0;
        bob::parallel_for(10, 1, [&](std::size_t, std::size_t) {
            bob::parallel_for(10, 1, [&](std::size_t begin, std::size_t) { sum += static_cast<int>(begin); });
        });
        CHECK_EQ(sum.load(), 450);
    });
}

TEST(parallel_for_stops_when_told) {
    with_threads([] {
        for (const int answered : {0, 1, 50}) {
            const auto caller = std::this_thread::get_id();
            std::atomic<int> by_caller = 0;
            CHECK(stops_after(answered, [&] {
                bob::parallel_for(100000, 1, [&](std::size_t, std::size_t) {
                    by_caller += std::this_thread::get_id() == caller;
                    while (std::this_thread::get_id() != caller) bob::Interruption::check(), std::this_thread::yield();
                });
            }));
            CHECK_EQ(by_caller.load(), answered);
        }
    });
}

TEST(only_the_caller_is_asked_whether_to_go_on) {
    with_threads([] {
        const auto caller = std::this_thread::get_id();
        std::atomic<int> by_others = 0;
        const bob::Interruption interruption([&] { return by_others += std::this_thread::get_id() != caller, true; });
        bob::parallel_for(100, 1, [&](std::size_t, std::size_t) { std::this_thread::yield(); });
        CHECK_EQ(by_others.load(), 0);
    });
}

TEST(parallel_for_passes_exceptions_on) {
    with_threads([] {
        for (int i = 0; i < 100; ++i) {
            bool caught = false;
            try {
                bob::parallel_for(64, 1, [](std::size_t begin, std::size_t) {
                    if (begin == 40) throw std::runtime_error("forty");
                });
            } catch (const std::runtime_error&) {
                caught = true;
            }
            CHECK(caught);
        }
    });
}

TEST(a_mutex_is_held_once) {
    bob::Mutex mutex;
    int sum = 0;
    std::vector<std::thread> threads;
    for (int i = 0; i < 4; ++i) {
        threads.emplace_back([&] {
            for (int k = 0; k < 10000; ++k) {
                const std::lock_guard lock(mutex);
                ++sum;
            }
        });
    }
    for (std::thread& thread : threads) thread.join();
    CHECK_EQ(sum, 40000);
}

#ifndef _WIN32  // which has no fork
TEST(a_forked_process_takes_a_mutex_over) {
    bob::Mutex mutex;
    mutex.lock();
    const pid_t child = fork();
    if (child == 0) {
        const bool taken = mutex.try_lock();
        _exit(taken && !mutex.try_lock() ? 0 : 1);
    }
    int status = -1;
    waitpid(child, &status, 0);
    CHECK_EQ(status, 0);
    CHECK(!mutex.try_lock());
    mutex.unlock();
    CHECK(mutex.try_lock());
}
#endif
