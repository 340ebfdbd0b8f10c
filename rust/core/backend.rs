//! The backends that can cast a scan.

use std::str::FromStr;

use crate::Error;

/// A way to cast scans. All backends give the same images, except for rounding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Backend {
    /// Shapes onto pixels, sixteen rays at once.
    Avx512,
    /// Shapes onto pixels, eight rays at once.
    Avx2,
    /// Shapes onto pixels, in plain Rust.
    Portable,
    /// Every ray through the hierarchies of the scene, in f64.
    Reference,
}

impl Backend {
    const ALL: [Backend; 4] = [Backend::Avx512, Backend::Avx2, Backend::Portable, Backend::Reference];

    /// The backends of this machine, the fastest first.
    pub fn available() -> Vec<Backend> {
        Backend::ALL.into_iter().filter(|backend| backend.is_available()).collect()
    }

    /// The fastest backend of this machine.
    pub fn fastest() -> Backend {
        Backend::ALL.into_iter().find(|backend| backend.is_available()).unwrap_or(Backend::Portable)
    }

    /// The name of the backend for callers.
    pub fn name(self) -> &'static str {
        match self {
            Backend::Avx512 => "avx512",
            Backend::Avx2 => "avx2",
            Backend::Portable => "portable",
            Backend::Reference => "reference",
        }
    }

    #[cfg(target_arch = "x86_64")]
    pub(crate) fn is_available(self) -> bool {
        let avx2 = || is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma");
        match self {
            Backend::Avx512 => {
                avx2()
                    && is_x86_feature_detected!("avx512f")
                    && is_x86_feature_detected!("avx512dq")
                    && is_x86_feature_detected!("avx512bw")
                    && is_x86_feature_detected!("avx512vl")
            }
            Backend::Avx2 => avx2(),
            Backend::Portable | Backend::Reference => true,
        }
    }

    #[cfg(not(target_arch = "x86_64"))]
    pub(crate) fn is_available(self) -> bool {
        matches!(self, Backend::Portable | Backend::Reference)
    }
}

impl FromStr for Backend {
    type Err = Error;

    /// The backend of that name, if this machine has it.
    fn from_str(name: &str) -> Result<Backend, Error> {
        let available = Backend::available();
        available.iter().copied().find(|backend| backend.name() == name).ok_or_else(|| Error::Backend {
            given: name.to_owned(),
            available: available.iter().map(|backend| backend.name()).collect::<Vec<_>>().join(", "),
        })
    }
}
