// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>

/// Restricts opening to regular files: a named pipe or a device in place of a file would block the program.
namespace crackle {

/// Kind of an object at a path other than a regular file: "a folder", "a named pipe", "a link that leads
/// nowhere". Empty for a regular file, also through a link, and if there is nothing.
std::string other_kind(const std::filesystem::path& file);

/// True if there is anything at a path, including a dangling link.
bool is_taken(const std::filesystem::path& file);

/// Refuses to open anything but a regular file. A missing file is left to the open call.
/// @throws std::runtime_error "X is a named pipe, not a file"
void require_regular(const std::filesystem::path& file);

/// "cannot write 'FILE': REASON"; the reason alone if it begins so.
std::string cannot_write(const std::filesystem::path& file, const std::string& reason);

/// The contents of a file; empty if there is none.
/// @throws std::runtime_error as require_regular, or when the file cannot be read
std::string read_text_if_any(const std::filesystem::path& file);

}  // namespace crackle
