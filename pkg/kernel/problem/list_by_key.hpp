// Items sorted by a key into consecutive lists (counting sort).
#pragma once

#include <cstdint>
#include <numeric>
#include <vector>

namespace rcr {

/// Lists the items of each key 0 … keys − 1 in the order in which they come. The list of key k is
/// items[begin[k]] … items[begin[k + 1] − 1]. forEach(add) calls add(key, item) for all items; it
/// runs twice and must add the same items.
template <class Item, class ForEach>
void listByKey(std::size_t keys, std::vector<std::int32_t>& begin, std::vector<Item>& items,
        ForEach forEach)
{
	begin.assign(keys + 2, 0);
	forEach([&](std::size_t key, const Item&) { ++begin[key + 2]; });
	std::partial_sum(begin.begin(), begin.end(), begin.begin());
	items.resize(begin.back());
	// while the list fills, begin[k + 1] is the next place of key k; afterwards it is its end
	forEach([&](std::size_t key, const Item& item) { items[begin[key + 1]++] = item; });
	begin.pop_back();
}

} // namespace rcr
