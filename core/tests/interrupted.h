/// Work that another thread stops.
#pragma once

#include "base/interruption.h"

/// Runs work() in an Interruption that says no to the question after `answered`. Returns whether the work was stopped then,
/// and asked no more.
template <class Work>
bool stops_after(int answered, Work work) {
    int asked = 0;
    const bob::Interruption interruption([&] { return asked++ < answered; });
    try {
        work();
    } catch (const bob::Stopped&) {
        return asked == answered + 1;
    }
    return false;
}
