// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/nearest_name.h"
#include "common/printable.h"
#include "common/quantity_text.h"

#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <new>
#include <optional>
#include <stdexcept>
#include <string>

namespace crackle {
namespace CRACKLE_TEST_FILE {

TEST(QuantityText, HasThePrefixThatItsSizeAsksFor) {
  EXPECT_EQ(quantity_text(160.04, "N"), "160 N");
  EXPECT_EQ(quantity_text(0.5, "N"), "0.5 N");
  EXPECT_EQ(quantity_text(4e-5, "N"), "40 uN");
  EXPECT_EQ(quantity_text(-9.5367e-7, "N"), "-953.7 nN");
  EXPECT_EQ(quantity_text(23456, "N"), "23.46 kN");
  EXPECT_EQ(quantity_text(0.02, "m"), "20 mm");
  EXPECT_EQ(quantity_text(0.0008, "m"), "0.8 mm");
  EXPECT_EQ(quantity_text(1.95e-6, "m"), "1.95 um");
  EXPECT_EQ(quantity_text(2e-12, "m^2"), "2 um^2");
  EXPECT_EQ(quantity_text(0, "N"), "0 N");
  EXPECT_EQ(quantity_text(0, "m"), "0 mm");
  EXPECT_EQ(quantity_text(40000, "s"), "40000 s");
  EXPECT_EQ(quantity_text(1e-20, "N"), "1e-08 pN");
}

TEST(Printable, HasNothingThatATerminalObeys) {
  EXPECT_EQ(printable("plate 3, 5 µm\tz\n"), "plate 3, 5 µm\tz\n");
  EXPECT_EQ(printable(std::string("a\0b", 3) + "\x1b[2J\r\x7f"), "a?b?[2J??");
  EXPECT_EQ(printable("\u009b31m, \u202eright"), "?31m, ?right");
  EXPECT_EQ(printable("Pr\xfc"
                      "fung \xe2\x82"),
            "Pr?fung ??");
}

TEST(Printable, NamesFailedAllocations) {
  EXPECT_EQ(reason_of(std::bad_alloc()), "there is not enough memory (std::bad_alloc)");
  EXPECT_EQ(reason_of(std::runtime_error("it rains")), "it rains");
}

TEST(NearestName, IsSpelledAlike) {
  const std::array<std::string, 3> known{"check", "match", "mesh"};
  EXPECT_EQ(nearest_name("chek", known), "check");
  EXPECT_EQ(nearest_name("mach", known), "match");
  EXPECT_EQ(nearest_name("plate.toml", known), std::nullopt);
}

TEST(QuantityText, HasTheUnitOfTheLargestBesideIt) {
  EXPECT_EQ(quantity_text(-0.0142, "N", 3, 12.3), "-0.0142 N");
  EXPECT_EQ(quantity_text(30, "N", 3, 2e4), "0.03 kN");
  EXPECT_EQ(quantity_text(0, "N", 3, 2e-4), "0 uN");
}

TEST(ShownUnit, StaysTheUsualOneWhileItShowsSomething) {
  const auto name = [](double largest) { return shown_unit({"mm", 1e3}, "m", largest).name; };
  EXPECT_EQ(name(0.02), "mm");
  EXPECT_EQ(name(1e-4), "mm");
  EXPECT_EQ(name(0), "mm");
  EXPECT_EQ(name(std::numeric_limits<double>::quiet_NaN()), "mm");
  EXPECT_EQ(name(2e-5), "mm");
  EXPECT_EQ(name(9e-6), "um");
  EXPECT_EQ(name(2e-8), "nm");
  EXPECT_EQ(name(5e3), "m");
}

TEST(ShownUnit, HasTheFactorOfItsName) {
  const ShownUnit area = shown_unit({"mm^2", 1e6}, "m^2", 3e-11);
  EXPECT_EQ(area.name, "um^2");
  EXPECT_DOUBLE_EQ(area.factor, 1e12);
  EXPECT_EQ(shown_unit({"mm^2", 1e6}, "m^2", 1.6e-13).name, "um^2");
  const ShownUnit energy = shown_unit({"J/m^2", 1}, "J/m^2", 0.0029);
  EXPECT_EQ(energy.name, "mJ/m^2");
  EXPECT_DOUBLE_EQ(energy.factor, 1e3);
  EXPECT_EQ(shown_unit({"%", 100}, "1", 1e-6).name, "%");
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle
