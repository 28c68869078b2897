#pragma once
#include <string>
#include <string_view>

namespace aberfit {

/// FNV-1a of 128 bits (Fowler, Noll, Vo; draft-eastlake-fnv), 32 hexadecimal digits: the same on every
/// machine. Tells cases and files apart, does not guard against forgery.
std::string content_hash(std::string_view bytes);

}  // namespace aberfit
