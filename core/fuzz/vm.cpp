/// .vm files: any bytes end in a formula or a VmError of one line. Small formulas are traced as solids.
#include <cstring>

#include "formula/vm.h"
#include "fuzz/formulas.h"
#include "shapes/implicit/vm_solid.h"

FUZZ(vm) {
    const bool traced = source.byte() % 16 == 't' % 16;  // tracing takes a hundred times as long as reading
    try {
        const bob::Expression f = bob::parse_vm(source.text());
        if (!traced || f.nodes().size() > 60) return;
        const bob::Interruption impatience(fuzz::Patience{fuzz::patience});
        const bob::VmSolid solid = bob::vm_solid(f);
        if (solid.bounds) fuzz::trace(solid.formula, *solid.bounds, source);
    } catch (const bob::VmError& error) {
        fuzz::expect(!std::strpbrk(error.what(), "\r\n") && error.line >= 1, "an error of one line, with its place");
    } catch (const bob::Stopped&) {
    }
}
