//! Frozen Python classes of named values: the results of the core.

/// Conversion of a value of the core to Python.
pub trait FromCore<T> {
    fn from_core(value: T) -> Self;
}

macro_rules! as_they_are {
    ($($type:ty),*) => { $(
        impl FromCore<$type> for $type {
            fn from_core(value: $type) -> Self {
                value
            }
        }
    )* };
}

as_they_are!(bool, f64, u8, u32, usize);

impl FromCore<&'static str> for String {
    fn from_core(value: &'static str) -> Self {
        value.to_owned()
    }
}

impl<S, T: FromCore<S>> FromCore<Option<S>> for Option<T> {
    fn from_core(value: Option<S>) -> Self {
        value.map(T::from_core)
    }
}

impl<S, T: FromCore<S>> FromCore<Vec<S>> for Vec<T> {
    fn from_core(values: Vec<S>) -> Self {
        values.into_iter().map(T::from_core).collect()
    }
}

impl<A, B, C: FromCore<A>, D: FromCore<B>> FromCore<(A, B)> for (C, D) {
    fn from_core((first, second): (A, B)) -> Self {
        (C::from_core(first), D::from_core(second))
    }
}

/// Declares a frozen class whose values are attributes. The constructor takes them in this order, and pickle and `repr` use
/// them. A class of the core (`from`) provides the values of the same names.
macro_rules! frozen_class {
    ($(#[$about:meta])* $name:ident from $core:ty { $($(#[$doc:meta])* $field:ident: $type:ty,)* }) => {
        frozen_class! { $(#[$about])* $name { $($(#[$doc])* $field: $type,)* } }

        impl $crate::frozen_class::FromCore<$core> for $name {
            fn from_core(value: $core) -> Self {
                Self { $($field: $crate::frozen_class::FromCore::from_core(value.$field)),* }
            }
        }
    };
    ($(#[$about:meta])* $name:ident { $($(#[$doc:meta])* $field:ident: $type:ty,)* }) => {
        $(#[$about])*
        #[pyclass(frozen, get_all, from_py_object, module = "sigmatau._core")]
        #[derive(Clone)]
        pub struct $name { $($(#[$doc])* pub $field: $type,)* }

        #[pymethods]
        impl $name {
            #[new]
            #[allow(clippy::too_many_arguments)] // one argument per value
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
