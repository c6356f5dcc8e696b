# SPDX-License-Identifier: GPL-3.0-or-later
"""Edits of an input file that know which line they changed."""
import re


class InputText:
    """The lines of an input file. Every edit sets `line` to the number (from 1) of the line it changed."""

    def __init__(self, text):
        self.lines = text.splitlines()
        self.line = 1

    def text(self):
        return "\n".join(self.lines) + "\n"

    def _header(self, table, number):
        headers = [i for i, line in enumerate(self.lines)
                   if line.split("#")[0].strip() in (f"[{table}]", f"[[{table}]]")]
        return headers[number]

    def _body(self, table, number):
        """Index range of the lines below a table's header."""
        start = self._header(table, number) + 1
        end = start
        while end < len(self.lines) and not self.lines[end].lstrip().startswith("["):
            end += 1
        return start, end

    def _key(self, table, key, number):
        start, end = self._body(table, number)
        for i in range(start, end):
            if re.match(rf"\s*{re.escape(key)}\s*=", self.lines[i]):
                return i
        raise KeyError(f"{table}.{key}")

    def set(self, table, key, value, number=0):
        """Gives the key another value, written as in the file; adds the key where it is not there."""
        try:
            i = self._key(table, key, number)
            self.lines[i] = f"{key} = {value}"
        except KeyError:
            i = self._header(table, number) + 1
            self.lines.insert(i, f"{key} = {value}")
        self.line = i + 1
        return self

    def drop(self, table, key, number=0):
        """Removes a key; the line is then that of the table's header."""
        del self.lines[self._key(table, key, number)]
        self.line = self._header(table, number) + 1
        return self

    def drop_table(self, table, number=0):
        start, end = self._body(table, number)
        del self.lines[start - 1:end]
        self.line = 1
        return self

    def drop_tables(self, table):
        while any(line.strip() == f"[[{table}]]" for line in self.lines):
            self.drop_table(table)
        return self

    def header(self, table, replacement, number=0):
        i = self._header(table, number)
        self.lines[i] = replacement
        self.line = i + 1
        return self

    def append(self, *lines, at=0):
        """Adds lines at the end; the line is that of number `at` of them."""
        self.line = len(self.lines) + 1 + at
        self.lines += lines
        return self

    def prepend(self, line):
        self.lines.insert(0, line)
        self.line = 1
        return self

    def at(self, table, key=None, number=0):
        """Moves `line` to a key or a table's header without a change."""
        self.line = 1 + (self._header(table, number) if key is None else self._key(table, key, number))
        return self
