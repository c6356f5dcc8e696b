// SPDX-License-Identifier: GPL-3.0-or-later
#include "commands.h"
#include "crackle/input/reader.h"
#include "crackle/parallel/agreement.h"

#include <sstream>
#include <string>
#include <vector>

namespace crackle::apps {

input::Parameters read_input(const parallel::Communicator& world, const std::filesystem::path& file,
                             const std::filesystem::path& points) {
  try {
    return parallel::agree(world, [&] { return input::read(file, points); });
  } catch (const parallel::AgreedError& error) {
    std::vector<std::string> messages;
    std::istringstream lines(error.what());
    for (std::string line; std::getline(lines, line);) messages.push_back(line);
    throw input::InputError(messages);
  }
}

}  // namespace crackle::apps
