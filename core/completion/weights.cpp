#include "completion/weights.h"

#include <stdexcept>

namespace bob {
namespace {

std::string text(const std::vector<int>& shape) {
    std::string result = "(";
    for (std::size_t i = 0; i < shape.size(); ++i) result += (i ? ", " : "") + std::to_string(shape[i]);
    return result + ")";
}

const Tensor& find(const Weights& weights, const std::string& name) {
    const auto found = weights.tensors.find(name);
    if (found == weights.tensors.end()) throw std::invalid_argument(name + ": expected in the weights, not found");
    return found->second;
}

}  // namespace

std::span<const float> tensor(const Weights& weights, const std::string& name, const std::vector<int>& shape) {
    const Tensor& found = find(weights, name);
    if (found.shape != shape) throw std::invalid_argument(name + ": expected shape " + text(shape) + ", got " + text(found.shape));
    return found.values;
}

Conv3x3 conv3x3(const Weights& weights, const std::string& name, int in, int out, int rows) {
    const Tensor& weight = find(weights, name + ".weight");
    const auto& shape = weight.shape;
    const int inputs = shape.size() == 4 ? shape[1] : 0;
    const int groups = inputs > 0 ? in / inputs : 0;
    const bool fits = groups > 0 && groups * inputs == in && out % groups == 0 && shape[0] == out && shape[2] == 3 &&
                      shape[3] == 3;
    if (!fits) {
        throw std::invalid_argument(name + ".weight: expected shape (" + std::to_string(out) + ", " +
                                    std::to_string(in) + " / groups, 3, 3), got " + text(shape));
    }
    return {weight.values, tensor(weights, name + ".bias", {out}), in, groups, rows};
}

Conv3x3 conv3x3(const Weights& weights, const std::string& name, int in, int rows) {
    const auto& shape = find(weights, name + ".weight").shape;
    if (shape.size() != 4 || shape[0] <= 0 || shape[0] % 4 != 0 || shape[1] != in) {
        throw std::invalid_argument(name + ".weight: expected shape (a multiple of 4, " + std::to_string(in) +
                                    ", 3, 3), got " + text(shape));
    }
    return conv3x3(weights, name, in, shape[0], rows);
}

}  // namespace bob
