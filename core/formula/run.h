/// Runs a formula's code on any number type. Only for *_kernels.cpp.
#pragma once

#include "formula/dual.h"
#include "formula/evaluate.h"
#include "formula/mesh_lanes.h"

namespace bob::BOB_ISA {

/// Runs the code on points or intervals, with or without slopes. Results of decisions, and of ops with poles, pass
/// through `decided(op, a, b, result)`.
template <class N, class Decided>
inline N run(const Code& code, const N& x, const N& y, const N& z, Domain& domain, void* scratch, Decided decided) {
    static_assert(sizeof(N) <= register_bytes);
    N* const registers = static_cast<N*>(scratch);
    registers[0] = x;
    registers[1] = y;
    registers[2] = z;
    for (const Instruction *i = code.instructions, *end = i + code.count; i != end; ++i) {
        const N &a = registers[i->a], &b = registers[i->b], &c = registers[i->c];
        N& out = registers[i->out];  // may alias an operand's register
        if (i->op == affine) {
            out = scaled(a, i->scale, i->offset);
            watch(out, domain);
            continue;
        }
        if (i->op == corner_distance) {
            out = decided(i->op, a, b, corner(a, b));
            continue;
        }
        if (i->op == piecewise_select) {
            domain.nowhere = M{};  // a NaN so far may be in the operand that is not chosen
            out = decided(i->op, a, b, piecewise(a, b, c));
            continue;
        }
        switch (i->op) {  // `continue` where numbers have a number, or the op sets the domain itself
            case Op::constant: set(out, i->offset); break;
            case Op::absolute: out = decided(i->op, a, a, abs(a)); continue;
            case Op::square: out = square(a); break;
            case Op::sqrt: out = sqrt(a, domain); continue;
            case Op::sin: out = sin(a, domain); continue;
            case Op::cos: out = cos(a, domain); continue;
            case Op::tan: out = decided(Op::tan, a, a, tan(a)); break;
            case Op::asin: out = asin(a, domain); continue;
            case Op::acos: out = acos(a, domain); continue;
            case Op::atan: out = atan(a); continue;
            case Op::exp: out = exp(a); break;
            case Op::log: out = log(a, domain); break;
            case Op::floor: out = decided(i->op, a, a, floor(a)); continue;
            case Op::ceil: out = decided(i->op, a, a, ceil(a)); continue;
            case Op::round: out = decided(i->op, a, a, round(a)); continue;
            case Op::power: out = power(a, static_cast<int>(i->scale)); break;
            case Op::add: out = a + b; break;
            case Op::subtract: out = a - b; break;
            case Op::multiply: out = a * b; break;
            case Op::divide: out = decided(Op::divide, a, b, divide(a, b, domain)); break;
            case Op::minimum: out = decided(i->op, a, b, minimum(a, b)); continue;
            case Op::maximum: out = decided(i->op, a, b, maximum(a, b)); continue;
            case Op::hypot: out = hypot(a, b); break;
            case Op::atan2: out = decided(i->op, a, b, atan2(a, b)); continue;
            case Op::modulo: out = modulo(a, b, domain); break;
            case Op::mesh_distance: out = mesh_distance(mesh_of(*i), a, b, c); break;
            case Op::select:
                domain.nowhere = M{};  // as above
                out = decided(i->op, a, b, select(a, b, c));
                continue;
            default: break;
        }
        watch(out, domain);
    }
    return registers[code.result];
}

template <class N>
inline N run(const Code& code, const N& x, const N& y, const N& z, Domain& domain, void* scratch) {
    return run(code, x, y, z, domain, scratch, [](Op, const N&, const N&, const N& result) { return result; });
}

}  // namespace bob::BOB_ISA
