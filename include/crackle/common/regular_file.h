// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>

/// What may be opened: a named pipe or a device in the place of a file would keep the program waiting.
namespace crackle {

/// What stands at a path where it is no regular file: "a folder", "a named pipe", "a link that leads
/// nowhere". Empty for a regular file, which a link may lead to, and where there is nothing.
std::string other_kind(const std::filesystem::path& file);

/// Whether there is anything at a path, be it a link that leads nowhere.
bool is_taken(const std::filesystem::path& file);

/// Refuses to open what is no regular file. Where there is nothing, opening says so.
/// @throws std::runtime_error "X is a named pipe, not a file"
void require_regular(const std::filesystem::path& file);

/// The content of a file; empty where there is none.
/// @throws std::runtime_error as require_regular, or when the file cannot be read
std::string read_text_if_any(const std::filesystem::path& file);

}  // namespace crackle
