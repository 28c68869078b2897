#pragma once
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

/// Rows of a CSV file under tests/data/golden by column name; lines that start with # are comments.
using GoldenRow = std::map<std::string, std::string>;

inline std::vector<GoldenRow> read_golden(const std::string& name) {
  std::ifstream file(std::string(ABERFIT_TEST_DATA) + "/golden/" + name);
  if (!file) throw std::runtime_error("no file " + name);
  std::vector<GoldenRow> rows;
  std::vector<std::string> header;
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::vector<std::string> cells;
    std::istringstream stream(line);
    for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
    if (header.empty()) {
      header = cells;
      continue;
    }
    GoldenRow& row = rows.emplace_back();
    for (std::size_t i = 0; i < header.size(); ++i) row[header[i]] = cells.at(i);
  }
  return rows;
}
