#include "threads.h"

#include <algorithm>
#include <atomic>
#include <thread>
#include <vector>

namespace {

using Clock = std::chrono::steady_clock;

constexpr auto signals_after = std::chrono::milliseconds(20);

/// Work normally stops within hundredths of a second; large files or a busy machine take longer.
constexpr auto longest_wait = std::chrono::seconds(10);

/// Python's identifier of its main thread.
std::atomic<unsigned long> main_thread = 0;

/// All threads except the main one.
struct Others {
    std::atomic<int> at_work = 0;
    std::atomic<int> coming_back = 0;  // threads waiting for the GIL
    std::atomic<bool> shall_stop = false;
    std::atomic<bool> may_come_back = true;
} others;

bool is_main_thread() { return PyThread_get_thread_ident() == main_thread; }

template <class Condition>
void wait_for(Condition condition, Clock::time_point until = Clock::time_point::max()) {
    while (!condition() && Clock::now() < until) std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

/// Stops the work of all other threads and waits for it. A thread that does not stop in time never returns to Python.
void end_work() {
    others.shall_stop = true;
    PyThreadState* const python = PyEval_SaveThread();
    wait_for([] { return others.at_work == 0; }, Clock::now() + longest_wait);
    others.may_come_back = false;
    wait_for([] { return others.coming_back == 0; });
    PyEval_RestoreThread(python);
}

/// A forked process has one thread, its main thread.
void begin_fork() {
    main_thread = PyThread_get_thread_ident();
    others.at_work = others.coming_back = 0;
}

/// Guarded by the GIL.
std::vector<const void*>& in_use() {
    static std::vector<const void*> objects;
    return objects;
}

}  // namespace

void leave_thread() {
    PyErr_SetNone(PyExc_SystemExit);
    throw nb::python_error();
}

WithoutGil::WithoutGil() : is_main_(is_main_thread()) {
    if (!is_main_) {
        if (others.shall_stop) leave_thread();
        ++others.at_work;
    }
    python_ = PyEval_SaveThread();
}

WithoutGil::~WithoutGil() {
    if (is_main_) {
        PyEval_RestoreThread(python_);
        return;
    }
    ++others.coming_back;
    if (!others.may_come_back) {
        --others.coming_back;
        while (true) std::this_thread::sleep_for(std::chrono::hours(1));
    }
    PyEval_RestoreThread(python_);
    --others.coming_back;
    --others.at_work;
}

bool WithoutGil::keeps_going() {
    if (!is_main_) return !others.shall_stop;
    const auto now = Clock::now();
    if (now - asked_ < signals_after) return true;
    asked_ = now;
    PyEval_RestoreThread(python_);
    raised_ = PyErr_CheckSignals() != 0;
    python_ = PyEval_SaveThread();
    return !raised_;
}

InUse::InUse(const void* object) : object_(object) {
    if (std::ranges::find(in_use(), object) != in_use().end()) {
        throw nb::value_error("expected one thread at a time, got another that uses the same object; each thread needs its own");
    }
    in_use().push_back(object);
}

InUse::~InUse() { std::erase(in_use(), object_); }

void bind_threads(nb::module_& m) {
    main_thread = nb::cast<unsigned long>(nb::module_::import_("threading").attr("main_thread")().attr("ident"));
    m.def("end_work", &end_work);
    nb::module_::import_("atexit").attr("register")(m.attr("end_work"));  // after all threads that Python waits for
    const nb::module_ os = nb::module_::import_("os");
    if (nb::hasattr(os, "register_at_fork")) {
        m.def("begin_fork", &begin_fork);
        os.attr("register_at_fork")(nb::arg("after_in_child") = m.attr("begin_fork"));
    }
}
