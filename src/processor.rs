//! Whether this processor has the instructions that the program was compiled with.
//!
//! Without this check a processor that lacks them ends the program with nothing but "Illegal instruction".
//! The compiler may use any of them in this file too, and std's own detection answers "yes" for those that
//! the program was compiled with. So what the processor says is gathered and judged by assembly, and what
//! follows where one is missing is text alone, written by std, which is compiled for every x86-64 processor.

use std::arch::asm;
use std::io::Write;

/// What one register of CPUID says, and the bits that this program needs of it.
struct Register {
    needed: u32,
    names: &'static [(u32, &'static str)],
}

/// A bit that is needed only if the program was compiled with its instructions.
const fn bit(is_compiled_in: bool, place: u32) -> u32 {
    (is_compiled_in as u32) << place
}

/// ECX of leaf 1. AVX stands for the registers too, which the system must save (XGETBV).
const BASIC: Register = Register {
    needed: bit(cfg!(target_feature = "sse3"), 0)
        | bit(cfg!(target_feature = "ssse3"), 9)
        | bit(cfg!(target_feature = "fma"), 12)
        | bit(cfg!(target_feature = "cmpxchg16b"), 13)
        | bit(cfg!(target_feature = "sse4.1"), 19)
        | bit(cfg!(target_feature = "sse4.2"), 20)
        | bit(cfg!(target_feature = "movbe"), 22)
        | bit(cfg!(target_feature = "popcnt"), 23)
        | bit(cfg!(target_feature = "avx"), OSXSAVE)
        | bit(cfg!(target_feature = "avx"), 28)
        | bit(cfg!(target_feature = "f16c"), 29),
    names: &[
        (1 << 0, " SSE3"),
        (1 << 9, " SSSE3"),
        (1 << 12, " FMA"),
        (1 << 13, " CMPXCHG16B"),
        (1 << 19, " SSE4.1"),
        (1 << 20, " SSE4.2"),
        (1 << 22, " MOVBE"),
        (1 << 23, " POPCNT"),
        (1 << OSXSAVE, " OSXSAVE"),
        (1 << 28, " AVX"),
        (1 << 29, " F16C"),
    ],
};

/// Bit of leaf 1's ECX: the system saves further registers, and XGETBV says which.
const OSXSAVE: u32 = 27;

/// EBX of leaf 7.
const EXTENDED: Register = Register {
    needed: bit(cfg!(target_feature = "bmi1"), 3)
        | bit(cfg!(target_feature = "avx2"), 5)
        | bit(cfg!(target_feature = "bmi2"), 8)
        | bit(cfg!(target_feature = "avx512f"), 16)
        | bit(cfg!(target_feature = "avx512dq"), 17)
        | bit(cfg!(target_feature = "avx512cd"), 28)
        | bit(cfg!(target_feature = "avx512bw"), 30)
        | bit(cfg!(target_feature = "avx512vl"), 31),
    names: &[
        (1 << 3, " BMI1"),
        (1 << 5, " AVX2"),
        (1 << 8, " BMI2"),
        (1 << 16, " AVX512F"),
        (1 << 17, " AVX512DQ"),
        (1 << 28, " AVX512CD"),
        (1 << 30, " AVX512BW"),
        (1 << 31, " AVX512VL"),
    ],
};

/// ECX of leaf 0x8000_0001.
const FURTHER: Register =
    Register { needed: bit(cfg!(target_feature = "lzcnt"), 5), names: &[(1 << 5, " LZCNT")] };

/// Bits of XCR0: the system saves the registers of SSE, of AVX, and the three parts of those of AVX-512.
const SAVED: Register = Register {
    needed: bit(cfg!(target_feature = "avx"), 1)
        | bit(cfg!(target_feature = "avx"), 2)
        | bit(cfg!(target_feature = "avx512f"), 5)
        | bit(cfg!(target_feature = "avx512f"), 6)
        | bit(cfg!(target_feature = "avx512f"), 7),
    names: &[(1 << 1, " SSE-state"), (1 << 2, " AVX-state"), (0b111 << 5, " AVX512-state")],
};

/// Ends the program with exit code 1 and a message if this processor lacks something.
#[inline(never)]
pub fn demand() {
    let lacking = lacking(found());
    let [basic, extended, further, saved] = lacking;
    if basic | extended | further | saved != 0 {
        refuse(lacking);
    }
}

/// What the four registers say; 0 for a leaf that the processor does not have.
#[inline(always)]
#[allow(unsafe_code, reason = "compiled Rust could use instructions that the processor lacks")]
fn found() -> [u32; 4] {
    let [mut basic, mut extended, mut further, mut saved] = [0u32; 4];
    // SAFETY: CPUID is there on every x86-64 processor, and a leaf is asked for only where the processor has
    // it. XGETBV is used only where OSXSAVE is set. RBX is put back, as the compiler may keep something in
    // it.
    unsafe {
        asm!(
            "mov {rbx}, rbx",
            // Leaf 1.
            "mov eax, 1",
            "xor ecx, ecx",
            "cpuid",
            "mov {basic:e}, ecx",
            // XCR0, if it can be asked.
            "bt ecx, {osxsave}",
            "jnc 2f",
            "xor ecx, ecx",
            "xgetbv",
            "mov {saved:e}, eax",
            "2:",
            // Leaf 7, if there is one.
            "xor eax, eax",
            "cpuid",
            "cmp eax, 7",
            "jb 3f",
            "mov eax, 7",
            "xor ecx, ecx",
            "cpuid",
            "mov {extended:e}, ebx",
            "3:",
            // Leaf 0x80000001, if there is one.
            "mov eax, 0x80000000",
            "cpuid",
            "cmp eax, 0x80000001",
            "jb 4f",
            "mov eax, 0x80000001",
            "cpuid",
            "mov {further:e}, ecx",
            "4:",
            "mov rbx, {rbx}",
            rbx = out(reg) _,
            basic = inout(reg) basic,
            extended = inout(reg) extended,
            further = inout(reg) further,
            saved = inout(reg) saved,
            osxsave = const OSXSAVE,
            out("eax") _,
            out("ecx") _,
            out("edx") _,
            options(nomem, nostack),
        );
    }
    [basic, extended, further, saved]
}

/// The bits of each register that are needed and not set. Compiled Rust would say it with ANDN, which may be
/// lacking.
#[inline(always)]
#[allow(unsafe_code, reason = "compiled Rust could use instructions that the processor lacks")]
fn lacking([mut basic, mut extended, mut further, mut saved]: [u32; 4]) -> [u32; 4] {
    // SAFETY: arithmetic on registers.
    unsafe {
        asm!(
            "not {basic:e}",
            "and {basic:e}, {basic_needed}",
            "not {extended:e}",
            "and {extended:e}, {extended_needed}",
            "not {further:e}",
            "and {further:e}, {further_needed}",
            "not {saved:e}",
            "and {saved:e}, {saved_needed}",
            basic = inout(reg) basic,
            extended = inout(reg) extended,
            further = inout(reg) further,
            saved = inout(reg) saved,
            basic_needed = const BASIC.needed,
            extended_needed = const EXTENDED.needed,
            further_needed = const FURTHER.needed,
            saved_needed = const SAVED.needed,
            options(pure, nomem, nostack),
        );
    }
    [basic, extended, further, saved]
}

#[cold]
#[inline(never)]
fn refuse(lacking: [u32; 4]) {
    let mut error = std::io::stderr();
    // Whom no message reaches is told by the exit code.
    let _ = error.write_all(b"error: this processor lacks what abbe was compiled for:");
    for (register, lacking) in REGISTERS.iter().zip(lacking) {
        for (bit, name) in register.names {
            if lacking & bit != 0 {
                let _ = error.write_all(name.as_bytes());
            }
        }
    }
    let _ = error.write_all(
        b"\nhelp: compile it for this processor, in its folder: RUSTFLAGS='-C target-cpu=native' cargo install --path . \
          (the same pictures, more slowly)\n",
    );
    std::process::exit(1);
}

const REGISTERS: [Register; 4] = [BASIC, EXTENDED, FURTHER, SAVED];

#[cfg(test)]
mod tests {
    use super::*;

    /// These tests run here, so nothing is lacking. An Intel Nehalem of 2008 lacks AVX and what came after
    /// it.
    #[test]
    fn what_an_old_processor_lacks_is_found() {
        assert_eq!(lacking(found()), [0; 4]);
        let nehalem = [1 | 1 << 9 | 1 << 13 | 1 << 19 | 1 << 20 | 1 << 23, 0, 1, 0];
        let mut expected = [0; 4];
        if cfg!(target_feature = "avx2") {
            expected[0] |= 1 << 12 | 1 << 22 | 1 << OSXSAVE | 1 << 28 | 1 << 29;
            expected[1] |= 1 << 3 | 1 << 5 | 1 << 8;
            expected[2] |= 1 << 5;
            expected[3] |= 1 << 1 | 1 << 2;
        }
        if cfg!(target_feature = "avx512f") {
            expected[1] |= 1 << 16 | 1 << 17 | 1 << 28 | 1 << 30 | 1 << 31;
            expected[3] |= 0b111 << 5;
        }
        assert_eq!(lacking(nehalem), expected);
        for (register, lacking) in REGISTERS.iter().zip(expected) {
            let named = register.names.iter().fold(0, |all, (bit, _)| all | bit);
            assert_eq!((named & lacking, register.needed & !named), (lacking, 0));
        }
    }
}
