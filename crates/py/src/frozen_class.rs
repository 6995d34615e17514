//! Frozen classes of named values, as Python sees the results of the core.

/// Declares a frozen class whose values are attributes. Its constructor takes them in their order; it is pickled and printed
/// by them.
macro_rules! frozen_class {
    ($(#[$about:meta])* $name:ident { $($(#[$doc:meta])* $field:ident: $type:ty,)* }) => {
        $(#[$about])*
        #[pyclass(frozen, get_all, from_py_object, module = "sigmatau._core")]
        #[derive(Clone)]
        pub struct $name { $($(#[$doc])* pub $field: $type,)* }

        #[pymethods]
        impl $name {
            #[new]
            #[allow(clippy::too_many_arguments)] // one for each value
            fn new($($field: $type),*) -> Self {
                Self { $($field),* }
            }

            fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyType>, Bound<'py, PyTuple>)> {
                let values = [$(slf.getattr(stringify!($field))?),*];
                Ok((slf.get_type(), PyTuple::new(slf.py(), values)?))
            }

            fn __repr__(slf: &Bound<'_, Self>) -> PyResult<String> {
                let values = [$(format!("{}={}", stringify!($field), slf.getattr(stringify!($field))?.repr()?)),*];
                Ok(format!("{}({})", stringify!($name), values.join(", ")))
            }
        }
    };
}

pub(crate) use frozen_class;
