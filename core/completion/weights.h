/// The contents of a weight file.
#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "completion/conv3x3.h"
#include "picture/channels.h"

namespace bob {

struct Tensor {
    std::vector<int> shape;
    std::span<const float> values;
};

struct Weights {
    Layout inputs, outputs;
    std::map<std::string, Tensor, std::less<>> tensors;  // by name
};

/// The values of a tensor. Throws std::invalid_argument, with its name, if it is missing or has another shape.
[[nodiscard]] std::span<const float> tensor(const Weights& weights, const std::string& name, const std::vector<int>& shape);

/// The convolution `name`, computed in steps of `rows` rows, from the tensors `name.weight` (out, in / groups, 3, 3)
/// and `name.bias` (out,). Their shapes determine the groups. Throws std::invalid_argument, with the tensor's name, if
/// one is missing or does not fit.
[[nodiscard]] Conv3x3 conv3x3(const Weights& weights, const std::string& name, int in, int out, int rows);

/// The same in one group, with the tensors' number of output channels, a multiple of 4.
[[nodiscard]] Conv3x3 conv3x3(const Weights& weights, const std::string& name, int in, int rows);

}  // namespace bob
