//! The flash for saved images: the two sectors of `STORE` in `memory.x`.
//!
//! An emulated chip has no flash to write. There two small sectors are in RAM that start-up code
//! does not initialize: they survive a reset, but not the emulator.

#![allow(unsafe_code)]

pub use device::StoreFlash;

#[cfg(not(feature = "qemu"))]
mod device {
    use core::slice;
    use embedded_storage::nor_flash::{
        ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash, check_erase, check_read, check_write,
    };
    use stm32f4xx_hal::flash::Error;
    use stm32f4xx_hal::pac;
    use stm32f4xx_hal::pac::flash::cr;

    /// Address of the two sectors, as in `memory.x`.
    const BEGIN: usize = 0x080c_0000;
    /// Number of the first sector.
    const FIRST: u8 = 10;
    /// Size of a sector, bytes.
    const SECTOR: usize = 128 * 1_024;
    /// Size of a word, bytes.
    const WORD: usize = 4;

    /// Keys that unlock the registers (RM0090, 3.5.1).
    const KEYS: [u32; 2] = [0x4567_0123, 0xcdef_89ab];
    /// Error bits of the status register: OPERR, WRPERR, PGAERR, PGPERR, PGSERR.
    const ERRORS: u32 = 0xf2;

    /// The last two sectors of the flash.
    pub struct StoreFlash(pac::FLASH);

    impl StoreFlash {
        /// Takes the flash.
        pub fn new(flash: pac::FLASH) -> Self {
            Self(flash)
        }

        /// Runs `work` with the registers unlocked.
        ///
        /// Writing 32 bits at once needs 2.7 V; below that, data may not last (RM0090, 3.6.2).
        fn change(
            &mut self,
            work: impl FnOnce(&pac::FLASH) -> Result<(), Error>,
        ) -> Result<(), Error> {
            // SAFETY: this register is only read, which has no side effects.
            let power = unsafe { pac::PWR::steal() };
            if power.csr().read().pvdo().bit_is_set() {
                return Err(Error::Operation);
            }
            let flash = &self.0;
            while flash.sr().read().bsy().bit_is_set() {}
            // After a debugger has written the program, error bits may be set and the registers
            // may be unlocked. Old errors would count as ours; writing keys to unlocked registers
            // locks them until the next reset.
            // SAFETY: a one clears its error bit and has no other effect.
            flash.sr().write(|w| unsafe { w.bits(ERRORS) });
            if flash.cr().read().lock().bit_is_set() {
                for key in KEYS {
                    flash.keyr().write(|w| w.key().set(key));
                }
            }
            if flash.cr().read().lock().bit_is_set() {
                return Err(Error::Operation);
            }
            let done = work(flash);
            // Ends erasing or writing, and locks.
            flash.cr().write(|w| w.lock().set_bit());
            self.forget();
            done
        }

        /// Clears the data cache, which the chip does not do after a change (RM0090, 3.4.2).
        fn forget(&self) {
            let control = self.0.acr();
            control.modify(|_, w| w.dcen().clear_bit());
            control.modify(|_, w| w.dcrst().set_bit());
            control.modify(|_, w| w.dcrst().clear_bit());
            control.modify(|_, w| w.dcen().set_bit());
        }
    }

    /// Sets the operation and a width of 32 bits; clears all other bits.
    fn by_words(flash: &pac::FLASH, what: impl FnOnce(&mut cr::W) -> &mut cr::W) {
        // `write` starts from the register's reset value, which is locked.
        flash
            .cr()
            .write(|w| what(w.psize().psize32()).lock().clear_bit());
    }

    /// Waits for the end of the operation and returns its error.
    fn wait(flash: &pac::FLASH) -> Result<(), Error> {
        // The write to the flash must leave the processor before the status is read.
        cortex_m::asm::dsb();
        while flash.sr().read().bsy().bit_is_set() {}
        let status = flash.sr().read();
        let errors = [
            (status.pgserr().bit_is_set(), Error::ProgrammingSequence),
            (status.pgperr().bit_is_set(), Error::ProgrammingParallelism),
            (status.pgaerr().bit_is_set(), Error::ProgrammingAlignment),
            (status.wrperr().bit_is_set(), Error::WriteProtection),
            (status.operr().bit_is_set(), Error::Operation),
        ];
        let error = errors.into_iter().find(|(is_set, _)| *is_set);
        error.map_or(Ok(()), |(_, error)| Err(error))
    }

    fn misplaced(_: NorFlashErrorKind) -> Error {
        Error::ProgrammingAlignment
    }

    impl ErrorType for StoreFlash {
        type Error = Error;
    }

    impl ReadNorFlash for StoreFlash {
        const READ_SIZE: usize = 1;

        fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Error> {
            check_read(self, offset, bytes.len()).map_err(misplaced)?;
            let from = (BEGIN + offset as usize) as *const u8;
            // SAFETY: the bytes are in the two sectors and do not change while `self` is borrowed.
            bytes.copy_from_slice(unsafe { slice::from_raw_parts(from, bytes.len()) });
            Ok(())
        }

        fn capacity(&self) -> usize {
            2 * SECTOR
        }
    }

    impl NorFlash for StoreFlash {
        const WRITE_SIZE: usize = WORD;
        const ERASE_SIZE: usize = SECTOR;

        fn erase(&mut self, from: u32, to: u32) -> Result<(), Error> {
            check_erase(self, from, to).map_err(misplaced)?;
            self.change(|flash| {
                for sector in from as usize / SECTOR..to as usize / SECTOR {
                    let number = FIRST + sector as u8;
                    // SAFETY: it is the number of one of the two sectors, which hold no code.
                    by_words(flash, |w| unsafe { w.ser().set_bit().snb().bits(number) });
                    // Started after all else is set (RM0090, 3.6.3).
                    flash.cr().modify(|_, w| w.strt().set_bit());
                    wait(flash)?;
                }
                Ok(())
            })
        }

        // Not inlined: one copy in flash.
        #[inline(never)]
        fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Error> {
            check_write(self, offset, bytes.len()).map_err(misplaced)?;
            self.change(|flash| {
                by_words(flash, |w| w.pg().set_bit());
                let (words, _) = bytes.as_chunks::<WORD>();
                let places = (BEGIN + offset as usize..).step_by(WORD);
                for (word, place) in words.iter().zip(places) {
                    // SAFETY: a whole word within the two sectors, where no Rust object is.
                    unsafe { (place as *mut u32).write_volatile(u32::from_le_bytes(*word)) };
                    wait(flash)?;
                }
                Ok(())
            })
        }
    }
}

#[cfg(feature = "qemu")]
mod device {
    use crate::RobotBody;
    use core::convert::Infallible;
    use core::mem::MaybeUninit;
    use core::ptr::addr_of_mut;
    use embedded_storage::nor_flash::{ErrorType, NorFlash, ReadNorFlash};
    use firmware::persist::slot_bytes;
    use stm32f4xx_hal::pac;

    /// Size of a sector, bytes: a mark and one image.
    const SECTOR: usize = (slot_bytes::<RobotBody>() as usize + 12).next_multiple_of(64);

    /// Not initialized by start-up code.
    #[unsafe(link_section = ".uninit.flash")]
    static mut BYTES: MaybeUninit<[u8; 2 * SECTOR]> = MaybeUninit::uninit();

    /// Two sectors in RAM.
    pub struct StoreFlash(*mut u8);

    // SAFETY: only one value exists, because there is only one `pac::FLASH`.
    unsafe impl Send for StoreFlash {}

    impl StoreFlash {
        /// Takes the flash, which is not used.
        pub fn new(_: pac::FLASH) -> Self {
            Self(addr_of_mut!(BYTES).cast())
        }

        /// Pointers to the bytes from `offset` on.
        fn places(&self, offset: u32) -> impl Iterator<Item = *mut u8> {
            // All are within the array.
            (offset as usize..2 * SECTOR).map(|index| self.0.wrapping_add(index))
        }
    }

    impl ErrorType for StoreFlash {
        type Error = Infallible;
    }

    impl ReadNorFlash for StoreFlash {
        const READ_SIZE: usize = 1;

        fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Infallible> {
            for (byte, place) in bytes.iter_mut().zip(self.places(offset)) {
                // SAFETY: only this object accesses the memory, and any bits are a byte.
                *byte = unsafe { place.read_volatile() };
            }
            Ok(())
        }

        fn capacity(&self) -> usize {
            2 * SECTOR
        }
    }

    impl NorFlash for StoreFlash {
        const WRITE_SIZE: usize = 4;
        const ERASE_SIZE: usize = SECTOR;

        fn erase(&mut self, from: u32, to: u32) -> Result<(), Infallible> {
            for place in self.places(from).take((to - from) as usize) {
                // SAFETY: as in `read`.
                unsafe { place.write_volatile(0xff) };
            }
            Ok(())
        }

        /// Like flash: bits change from one to zero only.
        fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Infallible> {
            for (byte, place) in bytes.iter().zip(self.places(offset)) {
                // SAFETY: as in `read`.
                unsafe { place.write_volatile(place.read_volatile() & byte) };
            }
            Ok(())
        }
    }
}
