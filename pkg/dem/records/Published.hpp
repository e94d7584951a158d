// A number that an engine changes and that Python may read at any time.
#pragma once

#include <atomic>

#include <boost/serialization/nvp.hpp>

#include "dem/yadeHeaders.hpp"

namespace yade {

template <class Value> class Published {
public:
	Published(Value value = {}) : value_(value) { }
	Published(const Published& other) : value_(Value(other)) { }
	Published& operator=(const Published& other) { return *this = Value(other); }
	Published& operator=(Value value)
	{
		value_.store(value, std::memory_order_relaxed);
		return *this;
	}
	operator Value() const { return value_.load(std::memory_order_relaxed); }

	template <class Archive> void serialize(Archive& archive, unsigned)
	{
		Value value = *this;
		archive & boost::serialization::make_nvp("value", value);
		if constexpr (Archive::is_loading::value) *this = value;
	}

	static void registerConverters()
	{
		boost::python::to_python_converter<Published, Published>();
		boost::python::implicitly_convertible<Value, Published>();
	}
	static PyObject* convert(const Published& number)
	{
		return boost::python::incref(boost::python::object(Value(number)).ptr());
	}

private:
	std::atomic<Value> value_;
};

} // namespace yade
