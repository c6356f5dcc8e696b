// SPDX-License-Identifier: GPL-3.0-or-later
#include "result_attributes.h"

namespace crackle::io {

using analysis::Reduction;

const analysis::ResultInfo status_info{
    "status", "", "state of the sample", Reduction::none, "status", "", 1, "d", analysis::status_categories};
const analysis::ResultInfo wall_time_info{
    "wall_time", "s", "wall time that the sample took", Reduction::none, "wall time", "s", 1, ".1f"};

void describe_result(hid_t parent, const std::string& dataset, const analysis::ResultInfo& info, int column) {
  const hdf5::Handle object(H5Dopen2(parent, dataset.c_str(), H5P_DEFAULT), H5Dclose, "dataset " + dataset);
  const hid_t id = object.get();
  hdf5::write_attribute(id, "column", std::int64_t{column});
  hdf5::write_attribute(id, "meaning", std::string(info.meaning));
  hdf5::write_attribute(id, "label", std::string(info.label));
  hdf5::write_attribute(id, "shown_units", std::string(info.shown_units));
  hdf5::write_attribute(id, "shown_factor", info.shown_factor);
  hdf5::write_attribute(id, "format", std::string(info.format));
  if (*info.categories != 0) hdf5::write_attribute(id, "categories", std::string(info.categories));
}

void describe_dataset(hid_t parent, const std::string& dataset, const std::string& meaning) {
  const hdf5::Handle object(H5Dopen2(parent, dataset.c_str(), H5P_DEFAULT), H5Dclose, "dataset " + dataset);
  hdf5::write_attribute(object.get(), "meaning", meaning);
}

}  // namespace crackle::io
