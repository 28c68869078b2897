#include "hdf5_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

namespace aberfit::internal {
namespace {

struct Hdf5Block {
  std::uint64_t place, length;
};

constexpr unsigned kHdf5Link = 0x06, kHdf5Outside = 0x07, kHdf5Attribute = 0x0c, kHdf5Continuation = 0x10,
                   kHdf5SymbolTable = 0x11;

std::uint64_t whole_eights(std::uint64_t bytes) { return (bytes + 7) / 8 * 8; }

std::uint64_t little_number(const FileBytes& bytes, std::uint64_t place, unsigned width) {
  std::uint64_t value = 0;
  for (unsigned i = 0; i < width; ++i) value |= std::uint64_t(bytes.at<std::uint8_t>(place + i)) << (8 * i);
  return value;
}

// Reads the datatype at `*place` and moves `*place` to its end; nothing for a type that is not needed here.
std::optional<Hdf5Type> read_type(const FileBytes& bytes, std::uint64_t* place, int depth = 0) {
  const unsigned head = bytes.at<std::uint8_t>(*place), version = head >> 4,
                 flags = bytes.at<std::uint16_t>(*place + 1);
  Hdf5Type type;
  type.kind = head & 0x0f;
  type.bytes = bytes.at<std::uint32_t>(*place + 4);
  type.big_endian = (flags & 1) != 0;
  *place += 8;
  constexpr int kDeepest = 4;
  if (version < 1 || version > 3 || depth > kDeepest) return std::nullopt;
  if (type.kind == Hdf5Type::kText) return type;
  if (type.kind == Hdf5Type::kInteger || type.kind == Hdf5Type::kFloat) {
    *place += type.kind == Hdf5Type::kInteger ? 4 : 12;
    return type;
  }
  if (type.kind == Hdf5Type::kVariable || type.kind == Hdf5Type::kArray) {
    type.variable_text = type.kind == Hdf5Type::kVariable && (flags & 0x0f) == 1;
    if (type.kind == Hdf5Type::kArray) {
      const std::uint64_t rank = bytes.at<std::uint8_t>(*place);
      *place += version < 3 ? 4 + 8 * rank : 1 + 4 * rank;  // sizes; before version 3 also a permutation
    }
    auto base = read_type(bytes, place, depth + 1);
    if (!base) return std::nullopt;
    type.base.push_back(*std::move(base));
    return type;
  }
  if (type.kind != Hdf5Type::kCompound) return std::nullopt;
  for (unsigned i = 0; i < flags; ++i) {
    const std::string_view rest = bytes.text(*place, bytes.size() - std::min(*place, bytes.size()));
    const std::uint64_t length = std::min(rest.find('\0'), rest.size());
    Hdf5Type::Member member{std::string(rest.substr(0, length)), 0, {}};
    *place += version < 3 ? whole_eights(length + 1) : length + 1;
    const unsigned width = version < 3             ? 4
                           : type.bytes < 1u << 8  ? 1
                           : type.bytes < 1u << 16 ? 2
                           : type.bytes < 1u << 24 ? 3
                                                   : 4;
    member.place = little_number(bytes, *place, width);
    *place += width + (version == 1 ? 28 : 0);  // version 1 stores array sizes here
    auto of = read_type(bytes, place, depth + 1);
    if (!of) return std::nullopt;
    member.type = *std::move(of);
    type.members.push_back(std::move(member));
  }
  return type;
}

bool is_one_value(const FileBytes& space) {
  const unsigned version = space.at<std::uint8_t>(0), rank = space.at<std::uint8_t>(1);
  constexpr unsigned kNull = 2;
  if (version < 1 || version > 2 || (version == 2 && space.at<std::uint8_t>(3) == kNull)) return false;
  for (unsigned i = 0; i < rank; ++i)
    if (space.at<std::uint64_t>((version == 1 ? 8 : 4) + 8 * i) != 1) return false;
  return true;
}

// Version 1 pads name, type and space to multiples of 8. Version 3 has a byte for the character set.
void take_attribute(const FileBytes& file, std::uint64_t place, std::uint64_t length,
                    std::map<std::string, Hdf5Value>* values) {
  const FileBytes body = file.part(place, length);
  const unsigned version = body.at<std::uint8_t>(0), shared = version == 1 ? 0 : body.at<std::uint8_t>(1);
  if (version < 1 || version > 3)
    file.fail(place, fmt::format("an attribute of version {}", version), "1 to 3");
  const auto padded = [&](std::uint64_t bytes) { return version == 1 ? whole_eights(bytes) : bytes; };
  const std::uint64_t name_bytes = body.at<std::uint16_t>(2), type_bytes = body.at<std::uint16_t>(4),
                      space_bytes = body.at<std::uint16_t>(6), name = version == 3 ? 9 : 8;
  const std::uint64_t type_place = name + padded(name_bytes), space = type_place + padded(type_bytes),
                      value = space + padded(space_bytes);
  const std::string_view text = body.text(name, name_bytes);
  std::uint64_t at = 0;
  if (shared != 0 || !is_one_value(body.part(space, space_bytes))) return;
  const auto type = read_type(body.part(type_place, type_bytes), &at);
  if (type)
    values->emplace(std::string(text.substr(0, text.find('\0'))),
                    Hdf5Value{*type, body.text(value, type->bytes)});
}

// Returns the place of the first messages of an object header.
Hdf5Block first_block(const FileBytes& file, std::uint64_t header, bool second, unsigned flags) {
  if (!second) return {header + 16, file.at<std::uint32_t>(header + 8)};
  const std::uint64_t place = header + 6 + (flags & 0x20 ? 16 : 0) + (flags & 0x10 ? 4 : 0);
  const unsigned width = 1u << (flags & 3);
  return {place + width, little_number(file, place, width)};
}

// Returns the elements in a global heap to which a value of variable length points, `element_bytes` each.
std::string_view heap_elements(const FileBytes& file, std::string_view pointer, std::uint64_t element_bytes) {
  const FileBytes where = file.with(pointer);
  const std::uint64_t count = where.at<std::uint32_t>(0), heap = where.at<std::uint64_t>(4);
  const std::uint64_t index = where.at<std::uint32_t>(12);
  if (count == 0) return {};
  if (file.text(heap, 4) != "GCOL" || file.at<std::uint8_t>(heap + 4) != 1)
    file.fail(heap, "no global heap of version 1", "GCOL, then the values of variable length");
  const std::uint64_t size = file.at<std::uint64_t>(heap + 8);
  file.text(heap, size);
  for (std::uint64_t place = heap + 16; place + 16 <= heap + size;) {
    const std::uint64_t found = file.at<std::uint16_t>(place), length = file.at<std::uint64_t>(place + 8);
    if (found == 0 || length > heap + size - place - 16) break;  // free space, or damage
    if (found == index) {
      if (length / element_bytes != count || length % element_bytes != 0)
        file.fail(place, fmt::format("{} bytes", length),
                  fmt::format("{} elements of {} bytes", count, element_bytes));
      return file.text(place + 16, length);
    }
    place += 16 + whole_eights(length);
  }
  file.fail(heap, fmt::format("a heap without value {}", index), "the value that an attribute points to");
}

// Calls `visit(type, place, length)` for the messages of an object header that are not shared.
template <class Visit>
void visit_messages(const FileBytes& file, std::uint64_t header, const Visit& visit) {
  const bool second = file.holds(header, 4) && file.text(header, 4) == "OHDR";
  const unsigned version = file.at<std::uint8_t>(second ? header + 4 : header);
  if (version != (second ? 2 : 1))
    file.fail(header, fmt::format("an object header of version {}", version), "1 or 2");
  const unsigned flags = second ? file.at<std::uint8_t>(header + 5) : 0;
  std::vector<Hdf5Block> blocks = {first_block(file, header, second, flags)};
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const Hdf5Block block = blocks[i];
    file.text(block.place, block.length);
    const std::uint64_t head = second ? (flags & 0x04 ? 6 : 4) : 8, end = block.place + block.length;
    for (std::uint64_t place = block.place; place + head <= end;) {
      const unsigned type = second ? file.at<std::uint8_t>(place) : file.at<std::uint16_t>(place);
      const std::uint64_t length = file.at<std::uint16_t>(place + (second ? 1 : 2));
      const unsigned message_flags = file.at<std::uint8_t>(place + (second ? 3 : 4));
      place += head;
      if (length > end - place)
        file.fail(place, fmt::format("a message of {} bytes", length), "one inside its block");
      constexpr unsigned kShared = 2;
      if ((message_flags & kShared) == 0) visit(type, place, length);
      if (type == kHdf5Continuation) {
        Hdf5Block next = {file.at<std::uint64_t>(place), file.at<std::uint64_t>(place + 8)};
        // In version 2 a signature precedes the block and a checksum follows it.
        if (second && next.length < 8)
          file.fail(place, "a part of a header without content", "8 bytes or more");
        if (second) next = {next.place + 4, next.length - 8};
        constexpr std::size_t kMostBlocks = 1000;
        const bool seen = std::any_of(blocks.begin(), blocks.end(),
                                      [&](const Hdf5Block& other) { return other.place == next.place; });
        if (seen || blocks.size() == kMostBlocks)
          file.fail(place, seen ? "a part of a header for the second time" : "too many parts of a header",
                    fmt::format("up to {} parts, each once", kMostBlocks));
        blocks.push_back(next);
      }
      place += length;
    }
  }
}

// Checks that a link of a newer group lies inside its message and points into this file.
void require_link(const FileBytes& file, std::uint64_t place, std::uint64_t length) {
  const FileBytes body = file.part(place, length);
  const unsigned flags = body.at<std::uint8_t>(1), kind = flags & 0x08 ? body.at<std::uint8_t>(2) : 0;
  constexpr unsigned kSoft = 1;
  if (kind > kSoft) file.fail(place, "a link", "a member of the file itself");
  const unsigned width = 1u << (flags & 3);
  const std::uint64_t name = 2 + (flags & 0x08 ? 1 : 0) + (flags & 0x04 ? 8 : 0) + (flags & 0x10 ? 1 : 0);
  body.text(name + width, little_number(body, name, width));
}

// Checks the tree of a group's members: every node has its signature, and so has the heap of names.
void require_group_nodes(const FileBytes& file, std::uint64_t root, std::uint64_t heap) {
  constexpr std::uint64_t kNowhere = ~std::uint64_t(0);
  const auto require = [&](std::uint64_t place, std::string_view signature) {
    if (!file.holds(place, 32) || file.text(place, 4) != signature)
      file.fail(std::min(place, file.size()), "another node of a group", std::string(signature));
  };
  require(heap, "HEAP");
  const std::uint64_t names = file.at<std::uint64_t>(heap + 24);
  file.text(names, file.at<std::uint64_t>(heap + 8));
  std::vector<std::uint64_t> nodes = {root};
  std::set<std::uint64_t> seen = {root};
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const std::uint64_t node = nodes[i];
    require(node, "TREE");
    const unsigned level = file.at<std::uint8_t>(node + 5), count = file.at<std::uint16_t>(node + 6);
    for (const std::uint64_t beside : {file.at<std::uint64_t>(node + 8), file.at<std::uint64_t>(node + 16)})
      if (beside != kNowhere) require(beside, "TREE");
    for (std::uint64_t child = 0; child < count; ++child) {  // a key precedes each child
      const std::uint64_t place = file.at<std::uint64_t>(node + 32 + 16 * child);
      require(place, level == 0 ? "SNOD" : "TREE");
      if (level == 0) continue;
      constexpr std::size_t kMostNodes = 10000;
      if (!seen.insert(place).second || nodes.size() == kMostNodes)
        file.fail(node, "a tree that goes in a circle or has too many nodes",
                  fmt::format("up to {} nodes, each once", kMostNodes));
      nodes.push_back(place);
    }
  }
}

}  // namespace

std::map<std::string, Hdf5Value> hdf5_attributes(const FileBytes& file, std::uint64_t header) {
  std::map<std::string, Hdf5Value> values;
  visit_messages(file, header, [&](unsigned type, std::uint64_t place, std::uint64_t length) {
    if (type == kHdf5Attribute) take_attribute(file, place, length, &values);
  });
  return values;
}

void require_hdf5_group(const FileBytes& file, std::uint64_t header) {
  visit_messages(file, header, [&](unsigned type, std::uint64_t place, std::uint64_t length) {
    if (type == kHdf5Link) require_link(file, place, length);
    if (type == kHdf5SymbolTable)
      require_group_nodes(file, file.at<std::uint64_t>(place), file.at<std::uint64_t>(place + 8));
  });
}

bool hdf5_data_outside(const FileBytes& file, std::uint64_t header) {
  bool outside = false;
  visit_messages(file, header, [&](unsigned type, std::uint64_t, std::uint64_t) {
    outside = outside || type == kHdf5Outside;
  });
  return outside;
}

std::optional<double> hdf5_number(const FileBytes& file, const Hdf5Value& value) {
  const auto [kind, bytes] = std::pair(value.type.kind, value.type.bytes);
  const FileBytes at = file.with(value.bytes);
  if (value.type.big_endian) return std::nullopt;
  if (kind == Hdf5Type::kFloat && bytes == 8) return at.at<double>(0);
  if (kind == Hdf5Type::kFloat && bytes == 4) return at.at<float>(0);
  if (kind == Hdf5Type::kInteger && bytes == 4) return at.at<std::int32_t>(0);
  return std::nullopt;
}

std::optional<std::string_view> hdf5_text(const FileBytes& file, const Hdf5Value& value) {
  std::string_view text = value.bytes;
  if (value.type.variable_text)
    text = heap_elements(file, value.bytes, 1);
  else if (value.type.kind != Hdf5Type::kText)
    return std::nullopt;
  return text.substr(0, text.find('\0'));
}

std::optional<std::vector<double>> hdf5_numbers(const FileBytes& file, const Hdf5Value& value) {
  if (value.type.base.empty() || value.type.variable_text) return std::nullopt;
  const Hdf5Type& base = value.type.base.front();
  if (base.kind != Hdf5Type::kFloat || base.bytes != 8 || base.big_endian) return std::nullopt;
  const std::string_view bytes =
      value.type.kind == Hdf5Type::kVariable ? heap_elements(file, value.bytes, 8) : value.bytes;
  std::vector<double> numbers;
  for (std::uint64_t place = 0; place + 8 <= bytes.size(); place += 8)
    numbers.push_back(file.with(bytes).at<double>(place));
  return numbers;
}

std::optional<Hdf5Value> hdf5_member(const FileBytes& file, const Hdf5Value& value, std::string_view name) {
  for (const Hdf5Type::Member& member : value.type.members)
    if (member.name == name)
      return Hdf5Value{member.type,
                       std::string_view(file.with(value.bytes).text(member.place, member.type.bytes))};
  return std::nullopt;
}

}  // namespace aberfit::internal
